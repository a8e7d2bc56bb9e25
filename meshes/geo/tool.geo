// The tool body: barrel, cap, hollow handle, coil-magazine can, hollow steel nose, cylinder sleeve.
//
// Lengths in mm, z up from the nose's tip, handle along +x; the mesh is saved in metres. Each DefineConstant is set by
// nailnoise from the design (gmsh -setnumber NAME VALUE); those below are the N80CB's.
//
// Barrel, cap and magazine are closed all round, the handle at its outer end; the nose is open at its tip. The sleeve
// stands on the barrel's floor, and a fit at its upper end, to be tied, holds it in the barrel. The can's wall meets the barrel's lower edge, and an arm joins it to the nose.

SetFactory("OpenCASCADE");

DefineConstant[
  barrel_radius = 37, barrel_wall = 4.5, barrel_height = 190,
  cap_radius = 46, cap_wall = 2.65, cap_height = 45,
  handle_radius = 20, handle_wall = 3.5, handle_length = 170, handle_level = 270,
  magazine_radius = 55, magazine_wall = 3, magazine_height = 70, magazine_offset = 75, magazine_level = 75,
  nose_width = 20, nose_depth = 30, nose_wall = 6, nose_height = 110, nose_overlap = 2,
  arm_depth = 12, arm_height = 30, arm_reach = 39,
  sleeve_radius = 30, sleeve_wall = 2, sleeve_height = 150, sleeve_fit = 10,
  size = 12,
  optimise = 1 // how folded elements are mended: 1 by optimisation of each, 2 by the elastic analogy before that
];

floor = nose_height;
roof = floor + barrel_height;
b = barrel_wall;
c = cap_wall;
m = magazine_wall;
e = 0.01; // slack of the boxes that pick surfaces

// Solids and their cavities, each hollowed by itself so that the wall between two of them stays.
Cylinder(1) = {0, 0, floor, 0, 0, barrel_height, barrel_radius};
Cylinder(2) = {0, 0, floor + b, 0, 0, barrel_height - 2*b, barrel_radius - b};
barrel() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
Cylinder(3) = {0, 0, roof, 0, 0, cap_height, cap_radius};
Cylinder(4) = {0, 0, roof + c, 0, 0, cap_height - 2*c, cap_radius - c};
cap() = BooleanDifference{ Volume{3}; Delete; }{ Volume{4}; Delete; };
grip = barrel_radius - 4; // from where the handle's length counts
Cylinder(5) = {0, 0, handle_level, grip + handle_length, 0, 0, handle_radius};
Cylinder(6) = {0, 0, handle_level, grip + handle_length - handle_wall, 0, 0, handle_radius - handle_wall};
handle() = BooleanDifference{ Volume{5}; Delete; }{ Volume{6}; Delete; };
h = magazine_height/2;
Cylinder(7) = {magazine_offset, -h, magazine_level, 0, 2*h, 0, magazine_radius};
Cylinder(8) = {magazine_offset, -(h - m), magazine_level, 0, 2*(h - m), 0, magazine_radius - m};
can() = BooleanDifference{ Volume{7}; Delete; }{ Volume{8}; Delete; };
Box(9) = {nose_width/2 - 1, -arm_depth/2, magazine_level - arm_height/2, arm_reach - nose_width/2 + 1, arm_depth, arm_height};
// Handle, can and arm end within the walls of barrel and cap, all round: a tube that ends in a plane would leave its cavity open at the
// sides of a round barrel.
Cylinder(10) = {0, 0, floor + b/2, 0, 0, barrel_height - b/2, barrel_radius - b/2};
Cylinder(11) = {0, 0, roof, 0, 0, cap_height - c/2, cap_radius - c/2};
core() = BooleanUnion{ Volume{10}; Delete; }{ Volume{11}; Delete; };
added() = BooleanDifference{ Volume{handle(), can(), 9}; Delete; }{ Volume{core()}; Delete; };
united() = BooleanUnion{ Volume{barrel()}; Delete; }{ Volume{added()}; Delete; };
// The cap may be of another material: where something joins it, there is cap.
housing() = BooleanDifference{ Volume{united()}; Delete; }{ Volume{cap()}; };

w = nose_width/2;
d = nose_depth/2;
t = nose_wall;
Box(100) = {-w, -d, 0, 2*w, 2*d, nose_height + nose_overlap};
Box(101) = {-w + t, -d + t, 0, 2*(w - t), 2*(d - t), nose_height + nose_overlap};
Box(102) = {-w, -d, 0, 2*w, 2*d, nose_height + nose_overlap};
// Where nose and housing overlap there is steel.
whole() = BooleanDifference{ Volume{housing()}; Delete; }{ Volume{102}; Delete; };
nose() = BooleanDifference{ Volume{100}; Delete; }{ Volume{101}; Delete; };

seated = sleeve_height - sleeve_fit;
Cylinder(110) = {0, 0, floor + b, 0, 0, seated, sleeve_radius + sleeve_wall};
Cylinder(111) = {0, 0, floor + b, 0, 0, seated, sleeve_radius};
sleeve() = BooleanDifference{ Volume{110}; Delete; }{ Volume{111}; Delete; };
If (sleeve_fit > 0)
  Cylinder(112) = {0, 0, floor + b + seated, 0, 0, sleeve_fit, sleeve_radius + sleeve_wall};
  Cylinder(113) = {0, 0, floor + b + seated, 0, 0, sleeve_fit, sleeve_radius};
  sleeve() += BooleanDifference{ Volume{112}; Delete; }{ Volume{113}; Delete; };
EndIf

// All of this is symmetric about y = 0: the half above is meshed, and nailnoise adds its image.
far = 2*(roof + cap_height + handle_length + magazine_offset + magazine_radius + magazine_height + cap_radius);
Box(200) = {-far, 0, -far, 2*far, far, 2*far};
whole() = BooleanIntersection{ Volume{whole()}; Delete; }{ Volume{200}; };
cap() = BooleanIntersection{ Volume{cap()}; Delete; }{ Volume{200}; };
nose() = BooleanIntersection{ Volume{nose()}; Delete; }{ Volume{200}; };
sleeve() = BooleanIntersection{ Volume{sleeve()}; Delete; }{ Volume{200}; Delete; };

BooleanFragments{ Volume{whole()}; Delete; }{ Volume{cap(), nose(), sleeve()}; Delete; }

// Parts, found again by where they lie.
steel() = Volume In BoundingBox {-w - e, -d - e, -e, w + e, d + e, nose_height + nose_overlap + e};
r = sleeve_radius + sleeve_wall;
tube() = Volume In BoundingBox {-r - e, -r - e, floor + b - e, r + e, r + e, floor + b + sleeve_height + e};
top() = Volume In BoundingBox {-cap_radius - e, -cap_radius - e, roof - e, cap_radius + e, cap_radius + e, roof + cap_height + e};
rest() = Volume{:};
rest() -= steel();
rest() -= top();
rest() -= tube();
Physical Volume("housing") = {rest()};
Physical Volume("cap") = {top()};
Physical Volume("nose") = {steel()};
Physical Volume("sleeve") = {tube()};

// Surfaces on which forces and lumped masses act. Each of them exists once in this geometry, half of it above the plane of
// symmetry.
tip() = Surface In BoundingBox {-w - e, -d - e, -e, w + e, d + e, e};
Physical Surface("nose_tip") = {tip()};
// The bore: the sleeve's inner side, below the seat of the head valve.
bore() = Surface In BoundingBox {-sleeve_radius - e, -sleeve_radius - e, floor + b - e, sleeve_radius + e, sleeve_radius + e, floor + b + sleeve_height + e};
bumper() = Surface In BoundingBox {-sleeve_radius - e, -sleeve_radius - e, floor + b - e, sleeve_radius + e, sleeve_radius + e, floor + b + e};
bore() -= bumper();
Physical Surface("gas_bore") = {bore()};
Physical Surface("bumper_seat") = {bumper()};
seat() = Surface In BoundingBox {-r - e, -r - e, floor + b + sleeve_height - e, r + e, r + e, floor + b + sleeve_height + e};
Physical Surface("seat") = {seat()};
q = barrel_radius - b;
// The fit: the outer side of the sleeve's upper end, and the barrel's inner side.
If (sleeve_fit > 0)
  fits() = Surface In BoundingBox {-r - e, -r - e, floor + b + seated - e, r + e, r + e, floor + b + sleeve_height + e};
  slave() = {};
  For k In {0 : #fits() - 1}
    box() = BoundingBox Surface{fits(k)};
    If (box(5) - box(2) > 0.1 && box(3) - box(0) > 2*r - sleeve_wall)
      slave() += fits(k);
    EndIf
  EndFor
  Physical Surface("fit_slave") = {slave()};
  inside() = Surface In BoundingBox {-q - e, -q - e, floor + b - e, q + e, q + e, roof - b + e};
  master() = {};
  For k In {0 : #inside() - 1}
    box() = BoundingBox Surface{inside(k)};
    If (box(5) - box(2) > 0.1 && box(3) - box(0) > q + r)
      master() += inside(k);
    EndIf
  EndFor
  Physical Surface("fit_master") = {master()};
Else
  inside() = Surface In BoundingBox {-q - e, -q - e, floor + b - e, q + e, q + e, roof - b + e};
  wall() = {};
  For k In {0 : #inside() - 1}
    box() = BoundingBox Surface{inside(k)};
    If (box(5) - box(2) > 0.1 && box(3) - box(0) > q + r)
      wall() += inside(k);
    EndIf
  EndFor
  Physical Surface("barrel_inside") = {wall()};
EndIf
// Around the sleeve, below its fit, lie the return volume and the supply's jacket.
around() = Surface In BoundingBox {-r - e, -r - e, floor + b - e, r + e, r + e, floor + b + seated + e};
jacket() = {};
For k In {0 : #around() - 1}
  box() = BoundingBox Surface{around(k)};
  If (box(5) - box(2) > 0.1 && box(3) - box(0) > 2*r - sleeve_wall)
    jacket() += around(k);
  EndIf
EndFor
Physical Surface("sleeve_outside") = {jacket()};
// Under the roof of the barrel the head valve strikes the cap.
under() = Surface In BoundingBox {-q - e, -q - e, roof - b - e, q + e, q + e, roof - b + e};
Physical Surface("cap") = {under()};
hr = handle_radius;
grips() = Surface In BoundingBox {0, -hr - e, handle_level - hr - e, grip + handle_length + e, hr + e, handle_level + hr + e};
outer() = {};
hollow() = {};
For k In {0 : #grips() - 1}
  box() = BoundingBox Surface{grips(k)};
  // The sides of the cavity are smaller than the outer ones; in the plane of symmetry a surface has no width.
  If (box(4) - box(1) > hr - 0.5*handle_wall)
    outer() += grips(k);
  ElseIf (box(4) - box(1) > e)
    hollow() += grips(k);
  EndIf
EndFor
Physical Surface("handle") = {outer()};
// Air of the supply fills the handle, the exhaust the cap.
Physical Surface("supply") = {hollow()};
cr = cap_radius - c;
plenum() = Surface In BoundingBox {-cr - e, -cr - e, roof + c - e, cr + e, cr + e, roof + cap_height - c + e};
Physical Surface("plenum") = {plenum()};
mr = magazine_radius;
cans() = Surface In BoundingBox {magazine_offset - mr - e, -h - e, magazine_level - mr - e, magazine_offset + mr + e, h + e, magazine_level + mr + e};
ends() = {};
For k In {0 : #cans() - 1}
  box() = BoundingBox Surface{cans(k)};
  If (box(4) - box(1) < 0.1 && Fabs(box(1) - h) < 0.1)
    ends() += cans(k);
  EndIf
EndFor
Physical Surface("magazine") = {ends()};

// Chords of the sleeve's two sides and of the barrel around it must not cross: a chord of length l lies l^2/(8 r) inside its arc.
// The longest sides are half as long again as the size.
near = 0.65*Sqrt(8*r*(q - r));
thin = 0.65*Sqrt(8*r*sleeve_wall);
If (thin < near)
  near = thin;
EndIf
walls() = Surface In BoundingBox {-q - e, -q - e, floor + b - e, q + e, q + e, roof - b + e};
If (near < size)
  Characteristic Length{ PointsOf{ Surface{walls()}; } } = near;
EndIf
// The same holds for the two sides of the handle's wall.
shell = 0.65*Sqrt(8*hr*handle_wall);
If (shell < size)
  Characteristic Length{ PointsOf{ Surface{outer(), hollow()}; } } = shell;
  If (shell < near)
    near = shell;
  EndIf
EndIf
// And for those of the walls of cap and magazine.
lid = 0.65*Sqrt(8*cap_radius*cap_wall);
If (lid < size)
  Characteristic Length{ PointsOf{ Volume{top()}; } } = lid;
  If (lid < near)
    near = lid;
  EndIf
EndIf
can_size = 0.65*Sqrt(8*mr*magazine_wall);
If (can_size < size)
  Characteristic Length{ PointsOf{ Surface{cans()}; } } = can_size;
  If (can_size < near)
    near = can_size;
  EndIf
EndIf
// Nor must chords of the rims of barrel and cap, which meet in one plane.
rim = 0.65*Sqrt(8*barrel_radius*Fabs(cap_radius - barrel_radius));
wide = (cap_radius > barrel_radius) ? cap_radius : barrel_radius;
rims() = Curve In BoundingBox {-wide - e, -wide - e, roof - e, wide + e, wide + e, roof + e};
If (rim < size && rim > 0)
  Characteristic Length{ PointsOf{ Curve{rims()}; } } = rim;
  If (rim < near)
    near = rim;
  EndIf
EndIf
// Nose in floor, arm between nose and can, and root of the handle bend locally and carry the lowest modes: elements there
// are a third as long. Without, the bare housing comes out up to 6 % too stiff.
fine = size/3;
Macro Joint
  Field[joint] = Box;
  Field[joint].XMin = x_(0); Field[joint].XMax = x_(1);
  Field[joint].YMin = -y_; Field[joint].YMax = y_;
  Field[joint].ZMin = z_(0); Field[joint].ZMax = z_(1);
  Field[joint].VIn = fine; Field[joint].VOut = size; Field[joint].Thickness = size;
Return
joint = 1; x_() = {-barrel_radius, barrel_radius}; y_ = barrel_radius; z_() = {floor - 2.5*b, floor + 2.5*b};
Call Joint;
joint = 2; x_() = {w - 2, arm_reach + arm_depth/2}; y_ = 1.5*arm_depth; z_() = {magazine_level - arm_height, magazine_level + arm_height};
Call Joint;
joint = 3; x_() = {hr, barrel_radius + hr/2}; y_ = 1.5*hr; z_() = {handle_level - 1.5*hr, handle_level + 1.5*hr};
Call Joint;
Field[4] = Min;
Field[4].FieldsList = {1, 2, 3};
Background Field = 4;
Mesh.CharacteristicLengthMax = size;
least = fine;
If (near < least)
  least = near;
EndIf
Mesh.CharacteristicLengthMin = least;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = optimise;
Mesh.ScalingFactor = 0.001;

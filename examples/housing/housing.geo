// A nailer housing of one casting, for docs/own-housing.md: gmsh examples/housing/housing.geo -0 -o housing.step
// Lengths in mm. The axis of the cylinder is x = y = 0, z is up from the tip of the nose, the handle points along +x.
SetFactory("OpenCASCADE");

// Barrel with its cylinder: the bore (60 mm) below, the chamber of the head valve above, closed by the cap.
Cylinder(1) = {0, 0, 110, 0, 0, 200, 40};
Cylinder(2) = {0, 0, 118, 0, 0, 150, 30};
Cylinder(3) = {0, 0, 268, 0, 0, 34, 36};
// Nose: a square tube, open at its tip.
Box(4) = {-13, -13, 0, 26, 26, 112};
Box(5) = {-7, -7, 0, 14, 14, 112};
// Handle, filled with supply air.
Cylinder(6) = {36, 0, 270, 170, 0, 0, 20};
Cylinder(7) = {44, 0, 270, 158, 0, 0, 16};
// Plate that carries the magazine.
Box(8) = {10, -4, 45, 95, 8, 60};

outer() = BooleanUnion{ Volume{1}; Delete; }{ Volume{4, 6, 8}; Delete; };
housing() = BooleanDifference{ Volume{outer()}; Delete; }{ Volume{2, 3, 5, 7}; Delete; };

// Meshes a solid geometry; lengths come in millimetres, whatever unit the file states.
// size: target of element sides. least, most: the longest side that is expected. solid: number of the solid that is meshed,
// 0 for all. elements: the most that memory allows, with its estimate in_volume V/size^3 + on_surface A/size^2.
// optimise: kind of optimisation of curved elements.
SetFactory("OpenCASCADE");
DefineConstant[ size = 10, least = 0, most = 1e22, solid = 0, elements = 1e22, in_volume = 1, on_surface = 1, optimise = 0 ];
loaded() = ShapeFromFile("GEOMETRY");
solids() = Volume{:};
faces() = Surface{:};
If (#solids() == 0 && #faces() > 0)
  // Faces by themselves, as IGES files have: those that close a volume are sewn to a solid. 1 um bridges rounding.
  Delete Model;
  SetFactory("OpenCASCADE");
  Geometry.Tolerance = 1e-3;
  Geometry.OCCSewFaces = 1;
  Geometry.OCCMakeSolids = 1;
  loaded() = ShapeFromFile("GEOMETRY");
  solids() = Volume{:};
  Geometry.OCCSewFaces = 0;
EndIf
If (#solids() == 0)
  Printf("%g", #faces()) > "sheets";
  Exit;
EndIf
For k In {0 : #solids() - 1}
  box() = BoundingBox Volume{solids(k)};
  mass() = Mass Volume{solids(k)};
  Printf("%.9g %.9g %.9g %.9g %.9g %.9g %.9g", mass(0), box(0), box(1), box(2), box(3), box(4), box(5)) >> "solids";
EndFor
If (solid > #solids())
  Exit;
EndIf
If (solid > 0)
  For k In {0 : #solids() - 1}
    If (k + 1 != solid)
      Recursive Delete { Volume{solids(k)}; }
    EndIf
  EndFor
EndIf
solids() = Volume{:};
If (#solids() > 1)
  Coherence;
  solids() = Volume{:};
EndIf
low_() = {1e22, 1e22, 1e22};
high_() = {-1e22, -1e22, -1e22};
volume = 0;
For k In {0 : #solids() - 1}
  box() = BoundingBox Volume{solids(k)};
  mass() = Mass Volume{solids(k)};
  volume += mass(0);
  For axis In {0 : 2}
    low_(axis) = (box(axis) < low_(axis)) ? box(axis) : low_(axis);
    high_(axis) = (box(3 + axis) > high_(axis)) ? box(3 + axis) : high_(axis);
  EndFor
EndFor
extent = Max(high_(0) - low_(0), Max(high_(1) - low_(1), high_(2) - low_(2)));
If (extent < least || extent > most)
  Printf("%.9g", extent) > "extent";
  Exit;
EndIf
area = 0;
faces() = Unique(Abs(Boundary{ Volume{solids()}; }));
For k In {0 : #faces() - 1}
  mass() = Mass Surface{faces(k)};
  area += mass(0);
EndFor
estimate = in_volume * volume / size^3 + on_surface * area / size^2;
If (estimate > elements)
  Printf("%.9g", estimate) > "elements";
  Exit;
EndIf
Physical Volume("body") = Volume{:};
Mesh.CharacteristicLengthMax = size;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = optimise;
Mesh.ScalingFactor = 0.001;

#!/usr/bin/env bash
# Writes the sample meshes of this folder; needs gmsh (4.8 or newer). Each holds a cube [0,1]^3, lower and upper half
# being the parts "lower" and "upper" where the kind of element allows two volumes, with the surfaces "floor" and "top".
set -euo pipefail
cd "$(dirname "$0")"

cube='
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Box(2) = {0, 0, 0.5, 1, 1, 0.5};
Coherence;
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
Physical Surface("floor") = Surface In BoundingBox {-0.01, -0.01, -0.01, 1.01, 1.01, 0.01};
Physical Surface("top") = Surface In BoundingBox {-0.01, -0.01, 0.99, 1.01, 1.01, 1.01};
Mesh.CharacteristicLengthMin = 1;
'
layers='
Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {1, 1, 0, 1}; Point(4) = {0, 1, 0, 1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 2, 3, 4} = 2;
Transfinite Surface {1};
'
hexahedra="$layers"'
Recombine Surface {1};
e() = Extrude {0, 0, 1} { Surface{1}; Layers{2}; Recombine; };
Physical Volume("cube") = {e(1)};
Physical Surface("floor") = {1};
Physical Surface("top") = {e(0)};
'
prisms="$layers"'
e() = Extrude {0, 0, 1} { Surface{1}; Layers{2}; Recombine; };
Physical Volume("cube") = {e(1)};
Physical Surface("floor") = {1};
Physical Surface("top") = {e(0)};
'
mesh() { # NAME SCRIPT ARGUMENTS...
    local name=$1 script=$2
    shift 2
    printf '%s' "$script" > "$name.geo"
    gmsh "$name.geo" -3 -v 2 -o "$name.msh" "$@"
    rm "$name.geo"
}
mesh tet10-22-text "$cube" -order 2 -format msh22
mesh tet10-22-binary "$cube" -order 2 -format msh22 -bin
mesh tet10-41-text "$cube" -order 2 -format msh41
mesh tet10-41-binary "$cube" -order 2 -format msh41 -bin
mesh tet4 "$cube" -order 1 -format msh41
mesh hex8 "$hexahedra" -order 1 -format msh41
mesh hex20 "$hexahedra" -order 2 -setnumber Mesh.SecondOrderIncomplete 1 -format msh41
mesh hex27 "$hexahedra" -order 2 -format msh41
mesh wedge15 "$prisms" -order 2 -setnumber Mesh.SecondOrderIncomplete 1 -format msh41
mesh wedge18 "$prisms" -order 2 -format msh41

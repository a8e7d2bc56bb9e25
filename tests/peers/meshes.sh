#!/usr/bin/env bash
# Reads the output of the command with programs that share no code with it: every .vtu with VTK, every .uff with pyuff,
# every .msh with gmsh, every .wav with Python's own reader. Also computes modes from a STEP file written by gmsh, and checks
# that a damaged mesh ends with status 2.
# Needs gmsh and Python with vtk, pyuff and numpy; `NAILNOISE` names the program, `PYTHON` the interpreter.
set -euo pipefail
for tool in gmsh "${PYTHON:-python3}"; do
    command -v "$tool" > /dev/null || { echo "tests/peers/meshes.sh needs $tool, which is missing" >&2; exit 1; }
done
"${PYTHON:-python3}" -c "import numpy, pyuff, vtkmodules" || { echo "pip install vtk pyuff numpy" >&2; exit 1; }
cd "$(dirname "$0")/../.."
nailnoise=$(realpath "${NAILNOISE:-target/release/nailnoise}")
python=${PYTHON:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A steel plate of 300 x 200 x 20 mm as STEP replaces the body of the tool.
cat > "$work/plate.geo" <<'GEO'
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 300, 200, 20};
GEO
gmsh "$work/plate.geo" -0 -v 1 -o "$work/plate.step" > /dev/null
cat > "$work/plate.toml" <<TOML
base = "$PWD/designs/n80cb.toml"
[body]
model = "rigid" # no run solves the plate: it lacks the surfaces of a tool
mesh = "plate.step"
lumped = false
[body.housing]
young_modulus = { value = "207 GPa", range = "200 .. 212 GPa" }
poisson_ratio = { value = 0.29, range = "0.27 .. 0.30" }
density = { value = "7850 kg/m3", range = "7750 .. 7900 kg/m3" }
[analysis]
body_max_frequency = "3 kHz"
body_element = { value = "20 mm", range = "10 .. 30 mm" }
TOML
"$nailnoise" modes "$work/plate.toml" --body tool --uff --animate 7 --out "$work/plate" --json > "$work/plate.json"
# The same by an option of the command line, for the block.
"$nailnoise" modes tests/data/small.toml --body workpiece --mesh "$work/plate.step" --out "$work/line" --json \
    > "$work/line.json"
# The whole chain: fields, films and sensors.
"$nailnoise" run tests/data/small.toml --fields --out "$work/run" --json > "$work/run.json"
# The program's own file serves as the measured one: every mode is its own best match.
"$nailnoise" modes "$work/plate.toml" --body tool --mac "$work/plate/modes/tool/modes.uff" --out "$work/again" --json \
    > "$work/mac.json"
"$nailnoise" check "$work/plate.toml" --body tool --json > "$work/check.json"
# No element side is longer than asked for, of the tool, the block or a geometry alone.
"$nailnoise" check "$work/plate.step" --size "18 mm" --json > "$work/fine.json"
"$nailnoise" check tests/data/small.toml --body workpiece --mesh "$work/plate.step" --size "25 mm" --json > "$work/block.json" || true
# In an elastic tool, the plate is refused with all surfaces that it lacks.
sed 's/"rigid"/"elastic"/' "$work/plate.toml" > "$work/elastic.toml"
status=0
"$nailnoise" run "$work/elastic.toml" --out "$work/none" 2> "$work/elastic" || status=$?
[[ $status == 2 ]] && grep -q gas_bore "$work/elastic" && grep -q '"cap"' "$work/elastic" || { cat "$work/elastic"; exit 1; }
# A unit for a geometry that states its own is refused before gmsh starts.
printf 'base = "plate.toml"\nbody.mesh_unit = "1 m"\n' > "$work/metres.toml"
status=0
timeout 60 "$nailnoise" check "$work/metres.toml" --body tool 2> "$work/metres" || status=$?
[[ $status == 2 ]] && grep -q 'states the unit' "$work/metres" || { cat "$work/metres"; exit 1; }
"$nailnoise" modes tests/data/small.toml --body worktable --uff --out "$work/small" --json > "$work/small.json"
for end in .vtu -22.msh -41.msh; do
    format=binary${end:1:2}
    [[ $end == .vtu ]] && format=binary41
    "$nailnoise" mesh designs/n80cb.toml --body tool --format "$format" --write "$work/tool$end" > /dev/null
done
for version in 22 41; do
    gmsh "$work/tool-$version.msh" -0 -v 2 -save -format msh41 -o "$work/gmsh-$version.msh"
    "$nailnoise" check "$work/gmsh-$version.msh" --unit "1 m" --json > "$work/gmsh-$version.json"
done
# Other dimensions require a new mesh.
cat > "$work/other.toml" <<TOML
base = "$PWD/designs/n80cb.toml"
body.handle_length = "160 mm"
TOML
"$nailnoise" mesh "$work/other.toml" --body tool --json > "$work/other.json"
if NAILNOISE_GMSH=no-such-gmsh "$nailnoise" mesh "$work/other.toml" --body tool 2> "$work/without"; then
    echo "new geometry without gmsh should fail" >&2
    exit 1
fi
tr '\n' ' ' < "$work/without" | grep -q "apt-get" || { cat "$work/without"; exit 1; }
# An inverted mesh in a design: the element, and status 2.
status=0
printf '%s\n' '$MeshFormat' '2.2 0 8' '$EndMeshFormat' '$PhysicalNames' '1' '3 1 "housing"' '$EndPhysicalNames' \
    '$Nodes' 4 '1 0 0 0' '2 1 0 0' '3 0 1 0' '4 0 0 1' '$EndNodes' '$Elements' 1 '17 4 2 1 1 1 3 2 4' '$EndElements' \
    > "$work/inverted.msh"
printf 'base = "%s/designs/n80cb.toml"\nbody.mesh = "inverted.msh"\nbody.mesh_unit = "0.3 m"\n' "$PWD" > "$work/inverted.toml"
"$nailnoise" modes "$work/inverted.toml" --body tool 2> "$work/inverted" || status=$?
[[ $status == 2 ]] && grep -q "element 17" "$work/inverted" || { cat "$work/inverted"; exit 1; }
"$python" tests/peers/meshes.py "$work"

#!/bin/bash
# The README's tables of drift: what each walk does, what friction does, and what trial 1 owes to step length, timing and
# height. Usage: tools/figures/drift_tables.sh [SEEDS [OUT_DIR]], from the project's folder; SEEDS as in 1..10.
set -euo pipefail
seeds=${1:-1..10}
out=${2:-results/drift_tables}
gaitslam=${GAITSLAM:-tools/gaitslam}

# mean (sd) of a metric over the seeds, times a factor, from the program's own table
metric() {
  awk -v name="$2" -v scale="$3" -v format="$4" '$1 == name {printf format, $5 * scale, $6 * scale}' "$1.log"
}

# one row: a name, a scenario, overrides
row() {
  local name=$1 scenario=$2 folder="$out/${1//[^a-zA-Z0-9.]/_}"
  shift 2
  "$gaitslam" run "scenarios/$scenario.yaml" "$@" --seeds "$seeds" --jobs 2 --without camera,slam --out "$folder" --force \
    > "$folder.log" 2>&1 || echo "$name: exit code $?, see $folder.log" >&2
  printf '| %s |' "$name"
  for axis in x y; do metric "$folder" "plan_drift_${axis}_m" 1000 ' %.0f (%.0f) |'; done
  metric "$folder" plan_drift_yaw_deg 1 ' %.1f (%.1f) |'
  for phase in landing support lift_off; do
    metric "$folder" "slip_${phase}_m" 1000 ' %.0f mm,'
    metric "$folder" "slip_${phase}_deg" 1 ' %.1f° |'
  done
  metric "$folder" contact_creep_m 1000 ' %.2f mm,'
  metric "$folder" contact_creep_deg 1 ' %.2f° |'
  metric "$folder" slip_drift_yaw_deg 1 ' %.1f° |'
  metric "$folder" put_down_drift_yaw_deg 1 ' %.1f° |'
  echo
}

mkdir -p "$out"
echo '| walk | x, mm | y, mm | yaw, deg | slip landing | slip support | slip lift-off | creep | yaw by slip | yaw by putting down |'
echo '|---|---|---|---|---|---|---|---|---|---|'
for walk in tangent_quadrant perpendicular_circle_trial1 perpendicular_circle straight_10m; do row "$walk" "$walk"; done
for friction in 0.2 0.3 0.4 0.6 0.8 1.0; do
  for walk in tangent_quadrant perpendicular_circle_trial1 perpendicular_circle; do
    row "$walk, friction $friction" "$walk" "world.floor_friction=$friction"
  done
done
trial1=perpendicular_circle_trial1
row 'trial 1, steps of 0.10 m' $trial1 walk.step_length_m=0.10
row 'trial 1, feet lifted 0.04 m' $trial1 walk.step_height_m=0.04
row 'trial 1, 0.75 and 0.05 s' $trial1 walk.single_support_s=0.75 walk.double_support_s=0.05

#!/bin/bash
# The README's tables of drift and slip, by walks without camera and filter.
# Usage: tools/figures/drift_tables.sh [TABLE [SEEDS [OUT_DIR]]], from the project's folder. TABLE is one of
#   walks     what each walk does: drift, slip phase by phase, creep, and where the drift comes from
#   arms      the same with each motion of the arms
#   friction  the nominal robot on floors of other friction
#   changes   the nominal robot: what trial 1 owes to step length, timing and height
# or all of them; SEEDS, of the first two, as in 1..10.
set -euo pipefail
table=${1:-all}
seeds=${2:-1..10}
out=${3:-results/drift_tables}
gaitslam=${GAITSLAM:-tools/gaitslam}
trial1=perpendicular_circle_trial1
circles="tangent_quadrant $trial1 perpendicular_circle"
nominal=(world.variation.{friction,joint_offset_rad,mass_fraction,com_m,posture_rad,servo_fraction,floor_height_m}=0
  errors.{gyro.sigma_rad_s,accelerometer.sigma_m_s2}=0)

# mean (sd) of a metric over the seeds, times a factor, from the program's own table
metric() {
  awk -v name="$2" -v scale="$3" -v format="$4" '$1 == name {printf format, $5 * scale, $6 * scale}' "$1.log"
}

# one row: a name, a scenario, overrides; what walks is in $seeds
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
  metric "$folder" contact_creep_m 1000 ' %.1f mm,'
  metric "$folder" contact_creep_deg 1 ' %.1f° |'
  for cause in slip put_down; do
    for axis in x y; do metric "$folder" "${cause}_drift_${axis}_m" 1000 ' %.0f,'; done
    metric "$folder" "${cause}_drift_yaw_deg" 1 ' %.1f° |'
  done
  echo
}

title() {
  printf '\n%s, seeds %s\n\n' "$1" "$seeds"
  echo '| walk | x, mm (sd) | y, mm (sd) | yaw, ° (sd) | slip landing | slip support | slip lift-off | creep | drift by slip, mm | drift by putting down, mm |'
  echo '|---|---|---|---|---|---|---|---|---|---|'
}

walks() {
  title 'Walks'
  for walk in $circles straight_10m; do row "$walk" "$walk"; done
}

arms() {
  title 'Arms'
  for walk in $circles; do
    for motion in still swing momentum; do row "$walk, $motion" "$walk" "walk.arm_motion=$motion"; done
  done
}

friction() {
  local seeds=1
  title 'Friction, nominal robot'
  for walk in $circles; do
    for mu in 0.15 0.16 0.18 0.2 0.3 0.4 0.7 1.0; do
      row "$walk, $mu" "$walk" "world.floor_friction=$mu" "${nominal[@]}"
    done
  done
}

changes() {
  local seeds=1
  title 'Trial 1 changed, nominal robot'
  row 'trial 1' $trial1 "${nominal[@]}"
  row 'trial 1, feet lifted 0.04 m' $trial1 walk.step_height_m=0.04 "${nominal[@]}"
  row 'trial 1, 0.75 and 0.05 s' $trial1 walk.single_support_s=0.75 walk.double_support_s=0.05 "${nominal[@]}"
  row 'trial 1, steps of 0.10 m' $trial1 walk.step_length_m=0.10 "${nominal[@]}"
  row 'trial 1, arms swinging' $trial1 walk.arm_motion=swing "${nominal[@]}"
  row 'trial 2' perpendicular_circle "${nominal[@]}"
}

mkdir -p "$out"
case $table in
  all) walks && arms && friction && changes ;;
  walks | arms | friction | changes) "$table" ;;
  *) echo "drift_tables.sh: $table: expected walks, arms, friction, changes or all" >&2; exit 2 ;;
esac

#!/bin/sh
# Checks that an installation is complete and works: install.sh CMAKE BUILD_FOLDER.
set -eu
cmake=$1 build=$2
place=$(mktemp -d "${TMPDIR:-/tmp}/gaitslam install XXXXXX")
trap 'rm -rf "$place"' EXIT
"$cmake" --install "$build" --prefix "$place/usr" >"$place/log"
cd "$place"
for file in bin/gaitslam include/gaitslam_estimator.h share/gaitslam/models/robots/hrp2/robot.xml share/gaitslam/scenarios/tangent_circle.yaml \
  share/gaitslam/schemas/score.schema.json share/man/man1/gaitslam.1 share/bash-completion/completions/gaitslam \
  share/zsh/vendor-completions/_gaitslam share/doc/gaitslam/copyright share/doc/gaitslam/CITATION.cff \
  share/doc/gaitslam/estimators.md share/doc/gaitslam/exports.md \
  $(sed -n 's|.*{"[a-z-]*", {"\([a-z/]*\)".*|share/gaitslam/\1/README.md|p' "$(dirname "$0")/../../tools/cli/help_command.cc"); do
  [ -f "usr/$file" ] || { echo "$file is not installed" >&2; exit 1; }
done

# An installed example compiles with one line.
cc -DGAITSLAM_ESTIMATOR_MAIN -I usr/include -o mine usr/share/gaitslam/examples/plan_alone.c

# The manual page names every command, and completion offers them and their options.
usr/bin/gaitslam --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p' >commands
[ "$(wc -l <commands)" -gt 10 ]
while read -r command; do
  grep -q -w "$command" usr/share/man/man1/gaitslam.1 || { echo "gaitslam.1 does not name $command" >&2; exit 1; }
done <commands
PATH=$place/usr/bin:$PATH bash -c '
  . usr/share/bash-completion/completions/gaitslam
  COMP_WORDS=(gaitslam ev) COMP_CWORD=1; _gaitslam; [ "${COMPREPLY[*]}" = evaluate ] || { echo "ev: ${COMPREPLY[*]}" >&2; exit 1; }
  COMP_WORDS=(gaitslam run x.yaml --see) COMP_CWORD=3; _gaitslam; [ "${COMPREPLY[*]}" = --seeds ] || { echo "--see: ${COMPREPLY[*]}" >&2; exit 1; }'

# Checks the plan against the furniture; this needs the models.
usr/bin/gaitslam check usr/share/gaitslam/scenarios/tangent_circle.yaml

# The package depends on the libraries that it links and on the ones that it loads at run time.
(cd "$build" && cpack -G DEB -B "$place/package" >"$place/log") || { cat "$place/log" >&2; exit 1; }
depends=$(dpkg-deb -f package/gaitslam_*.deb Depends)
for library in libmujoco libopencv-core libopencv-imgcodecs libosmesa6; do
  case $depends in *$library*) ;; *) echo "the package does not depend on $library: $depends" >&2; exit 1 ;; esac
done

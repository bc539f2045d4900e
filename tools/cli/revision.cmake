# Writes OUTPUT, a source file with the git revision of SOURCE and the hash of the sources that affect recordings. It is not rewritten if nothing changed, so that a build
# with nothing to do does nothing.
find_program(GIT git)
set(REVISION unknown)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --short=12 HEAD
    OUTPUT_VARIABLE HEAD OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE NO_HEAD)
  if(NOT NO_HEAD)
    execute_process(COMMAND ${GIT} -C ${SOURCE} diff-index --quiet HEAD -- RESULT_VARIABLE DIFFERS ERROR_QUIET)
    set(REVISION "${HEAD}")
    if(DIFFERS)
      string(APPEND REVISION "+")
    endif()
  endif()
endif()

# RECORDING_SOURCES_HASH: a hash of the names and contents of all files below SOURCE that affect a recording. Anything not
# listed here (filter, scores, pages, reading and printing of scenarios) may change without invalidating earlier recordings.
file(GLOB_RECURSE RECORDING_SOURCES RELATIVE ${SOURCE}
  ${SOURCE}/walking/*.cc ${SOURCE}/walking/*.h ${SOURCE}/sim/controllers/*.cc ${SOURCE}/sim/controllers/*.h
  ${SOURCE}/sim/model_file/*.cc ${SOURCE}/sim/model_file/*.h ${SOURCE}/sim/physics/*.cc ${SOURCE}/sim/physics/*.h ${SOURCE}/sim/camera/*.cc ${SOURCE}/sim/camera/*.h
  ${SOURCE}/sim/room/*.cc ${SOURCE}/sim/room/*.h ${SOURCE}/sim/rig/*.cc ${SOURCE}/sim/rig/*.h)
list(APPEND RECORDING_SOURCES
  sim/recording/recording.h sim/recording/recording_writer.cc sim/scenario/lists.cc sim/score/surfaces.cc sim/score/types.h)
foreach(PART files/csv files/hash recording/image_file recording/manifest recording/recording_format recording/sensor_yaml sensor_errors/random
    estimators/messages live/frame_pipeline live/steering_pose_buffer live/run live/self_check live/setup scenario/robot)
  list(APPEND RECORDING_SOURCES sim/${PART}.cc sim/${PART}.h)
endforeach()
list(SORT RECORDING_SOURCES)
set(TEXT "")
foreach(FILE ${RECORDING_SOURCES})
  file(SHA256 ${SOURCE}/${FILE} HASH)  # an error if a file is missing: update this list
  string(APPEND TEXT "${HASH} ${FILE}\n")
endforeach()
string(SHA256 RECORDING_SOURCES_HASH "${TEXT}")
string(SUBSTRING ${RECORDING_SOURCES_HASH} 0 16 RECORDING_SOURCES_HASH)

set(TEXT "namespace cli {
extern const char *const kRevision, *const kRecordingSources;
const char* const kRevision = \"${REVISION}\";
const char* const kRecordingSources = \"${RECORDING_SOURCES_HASH}\";
}  // namespace cli
")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} BEFORE)
endif()
if(NOT TEXT STREQUAL "${BEFORE}")
  file(WRITE ${OUTPUT} "${TEXT}")
endif()

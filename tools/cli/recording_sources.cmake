# Sets RECORDING_SOURCES_HASH: of all files below SOURCE that shape a recording, names and contents. What is not here (filter,
# scores, pages, scenarios read and printed) may change, and recordings that were made before still serve.
file(GLOB_RECURSE RECORDING_SOURCES RELATIVE ${SOURCE}
  ${SOURCE}/walking/*.cc ${SOURCE}/walking/*.h
  ${SOURCE}/sim/world/*.cc ${SOURCE}/sim/world/*.h)
list(APPEND RECORDING_SOURCES
  sim/stream/recording.h sim/stream/recording_format.h sim/stream/recording_writer.cc)
foreach(PART draw planned_camera run scenario_commands scenario_disturbances self_check)
  list(APPEND RECORDING_SOURCES sim/bench/${PART}.cc sim/bench/${PART}.h)
endforeach()
foreach(PART csv manifest plan_row random sensor_yaml)
  list(APPEND RECORDING_SOURCES sim/stream/${PART}.cc sim/stream/${PART}.h)
endforeach()
list(SORT RECORDING_SOURCES)
set(TEXT "")
foreach(FILE ${RECORDING_SOURCES})
  file(SHA256 ${SOURCE}/${FILE} HASH)  # an error where there is no such file: this list is to be mended then
  string(APPEND TEXT "${HASH} ${FILE}\n")
endforeach()
string(SHA256 RECORDING_SOURCES_HASH "${TEXT}")
string(SUBSTRING ${RECORDING_SOURCES_HASH} 0 16 RECORDING_SOURCES_HASH)

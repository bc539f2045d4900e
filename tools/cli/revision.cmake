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
include(${CMAKE_CURRENT_LIST_DIR}/recording_sources.cmake)
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

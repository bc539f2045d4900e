# The compiler options of all targets: each links gaitslam_options, directly or indirectly.
add_library(gaitslam_options INTERFACE)
target_include_directories(gaitslam_options INTERFACE ${PROJECT_SOURCE_DIR})

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # -Wsubobject-linkage takes the anonymous namespaces of a unity file's sources for a header's. The others are false alarms
  # about std::string in GCC 12 (GCC bugs 105329 and 105651) that depend on the length of a literal, such as the checkout's
  # path; the address sanitizer covers them.
  foreach(false_alarm subobject-linkage array-bounds restrict stringop-overflow stringop-overread)
    target_compile_options(gaitslam_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-${false_alarm}>)
  endforeach()
endif()

# One instruction set and no implicit fused multiply-add: the same bits on every such machine.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(gaitslam_options INTERFACE -march=x86-64-v3)
endif()
target_compile_options(gaitslam_options INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow
  $<$<BOOL:${GAITSLAM_WERROR}>:-Werror>)
# Eigen's products keep their work space up to this size on the stack, so that a step of the filter touches no heap.
target_compile_definitions(gaitslam_options INTERFACE EIGEN_STACK_ALLOCATION_LIMIT=1048576)

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # A tenth of a compilation would be spent on collecting garbage below half a gigabyte.
  target_compile_options(gaitslam_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=524288>)
  find_program(GAITSLAM_GOLD ld.gold)  # links in a quarter of the time
  if(GAITSLAM_GOLD)
    target_link_options(gaitslam_options INTERFACE -fuse-ld=gold)
  endif()
endif()

if(GAITSLAM_SANITIZE)
  # Only the undefined behavior that the address sanitizer does not see: checking every pointer would triple the time that
  # Eigen's templates take to compile.
  set(undefined signed-integer-overflow,float-cast-overflow,shift,integer-divide-by-zero,bounds,enum,bool,return,unreachable)
  set(checks_address address,${undefined})
  set(checks_undefined ${undefined})
  set(checks_thread thread)
  set(checks ${checks_${GAITSLAM_SANITIZE}})
  if(NOT checks)
    message(FATAL_ERROR "GAITSLAM_SANITIZE=${GAITSLAM_SANITIZE}: expected address, undefined or thread")
  endif()
  target_compile_options(gaitslam_options INTERFACE $<IF:$<STREQUAL:${GAITSLAM_SANITIZE},undefined>,-O2,-O1>
    -gline-tables-only -fno-omit-frame-pointer -fsanitize=${checks} -fno-sanitize-recover=all)
  target_compile_definitions(gaitslam_options INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(gaitslam_options INTERFACE -fsanitize=${checks})
endif()
if(GAITSLAM_FUZZ)
  target_compile_options(gaitslam_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# For code that runs faster than it compiles: the optimizer would take a fifth to a half of the compilation.
add_library(gaitslam_quick_build INTERFACE)
target_link_libraries(gaitslam_quick_build INTERFACE gaitslam_options)
target_compile_options(gaitslam_quick_build INTERFACE
  $<$<CONFIG:Release>:-O1> $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # false alarms with -O1

# The compiler options of all targets: each links gaitslam_options, directly or indirectly.
add_library(gaitslam_options INTERFACE)
target_include_directories(gaitslam_options INTERFACE ${PROJECT_SOURCE_DIR})

# One instruction set and no implicit fused multiply-add, so that every such machine computes the same bits.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(gaitslam_options INTERFACE -march=x86-64-v3)
endif()
target_compile_options(gaitslam_options INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow
  $<$<BOOL:${GAITSLAM_WERROR}>:-Werror>)
# Eigen's products keep workspaces of up to this size on the stack, so that a filter step does not touch the heap.
target_compile_definitions(gaitslam_options INTERFACE EIGEN_STACK_ALLOCATION_LIMIT=1048576)

# Without it, a compiler cache cannot reuse what was compiled with a precompiled header.
target_compile_options(gaitslam_options INTERFACE "SHELL:-Xclang -fno-pch-timestamp")
find_program(GAITSLAM_GOLD ld.gold)  # links in a quarter of the time
if(GAITSLAM_GOLD)
  target_link_options(gaitslam_options INTERFACE -fuse-ld=gold)
endif()

if(GAITSLAM_SANITIZE)
  # Only the undefined behavior that the address sanitizer does not detect: checking every pointer would triple the compile time
  # of Eigen's templates.
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

# For code whose compile time matters more than its speed: the optimizer would take a fifth to a half of the compile time.
add_library(gaitslam_quick_build INTERFACE)
target_link_libraries(gaitslam_quick_build INTERFACE gaitslam_options)
target_compile_options(gaitslam_quick_build INTERFACE
  $<$<CONFIG:Release>:-O1>)

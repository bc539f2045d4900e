# Read by cpack. Without these programs, CPack would write a package without dependencies.
cmake_policy(VERSION 3.25)
foreach(program dpkg-shlibdeps file)
  find_program(${program}_program ${program})
  if(NOT ${program}_program)
    message(FATAL_ERROR "cpack: ${program} is missing; apt-get install dpkg-dev file")
  endif()
endforeach()

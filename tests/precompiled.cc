// Only so that CMake has a source to compile precompiled.h for.

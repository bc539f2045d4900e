// The source that CMake needs to compile precompiled headers.

// An empty source, which CMake needs to compile precompiled headers.

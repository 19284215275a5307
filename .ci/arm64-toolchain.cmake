# Builds for 64-bit ARM (a Raspberry Pi) on another machine: cmake -DCMAKE_TOOLCHAIN_FILE=...
# The core alone needs g++-aarch64-linux-gnu only; the daemon Debian's libraries of that architecture
# (.ci/install-packages arm64).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# GCC's note that GCC 10 passes pairs of doubles otherwise than GCC 9 did.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
# Debian keeps each architecture's libraries in a folder of its own below /usr/lib, which CMake knows; pkg-config has to
# be told.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)

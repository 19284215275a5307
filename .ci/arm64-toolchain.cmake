# Builds for 64-bit ARM (a Raspberry Pi) on another machine: cmake -DCMAKE_TOOLCHAIN_FILE=... -DCONTOURD_CORE_ONLY=ON
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# GCC's note that GCC 10 passes pairs of doubles otherwise than GCC 9 did.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
# An emulated program finds no libraries of its own architecture here.
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)
set(CMAKE_FIND_ROOT_PATH /usr/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)

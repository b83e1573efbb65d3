# aarch64 (Jetson, IGX) by Debian's cross compiler: crossbuild-essential-arm64 and libraries of the architecture arm64
# (tools/cross_arm64.sh installs them). Tests and programs of the build run under qemu-user where it is installed.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# pkg-config must not find packages of this machine's own architecture.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
find_program(FIRE3DV_QEMU_AARCH64 NAMES qemu-aarch64-static qemu-aarch64)
if(FIRE3DV_QEMU_AARCH64)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${FIRE3DV_QEMU_AARCH64})
endif()

# Put into what is installed all that it needs (-DCPINN_BUNDLED=ON, for a wheel). HDF5, SUNDIALS,
# libyaml and zlib are archives, so that none of them is loaded at start-up. OpenBLAS chooses its
# kernels while it is loaded (autodiff/run/blas.c), so it stays a library, as a copy with a name of its
# own: a process that has numpy or another OpenBLAS keeps them apart.
find_program(PATCHELF patchelf REQUIRED)
find_library(CPINN_SZIP sz REQUIRED)
find_library(CPINN_AEC aec REQUIRED)
add_link_options(LINKER:--wrap=hypot,--wrap=hypotf)

# Debian compiles the archive of HDF5 for programs. A shared library can take it but for stderr and
# stdout, which are variables of another library there.
set(bundled_hdf5 ${CMAKE_CURRENT_BINARY_DIR}/libhdf5_bundled.a)
execute_process(COMMAND ${CMAKE_OBJCOPY} --redefine-sym stderr=cpinn_stderr
    --redefine-sym stdout=cpinn_stdout ${pkgcfg_lib_HDF5_hdf5} ${bundled_hdf5}
    COMMAND_ERROR_IS_FATAL ANY)
set_target_properties(PkgConfig::HDF5 PROPERTIES INTERFACE_LINK_LIBRARIES
    "${bundled_hdf5};${CPINN_SZIP};${CPINN_AEC};PkgConfig::ZLIB;m;${CMAKE_DL_LIBS}")

set(CMAKE_FIND_LIBRARY_SUFFIXES .so)
find_library(CPINN_SYSTEM_OPENBLAS openblas REQUIRED)
set(CPINN_OPENBLAS ${CMAKE_CURRENT_BINARY_DIR}/libcpinn_openblas.so CACHE INTERNAL "the copy")
file(REAL_PATH ${CPINN_SYSTEM_OPENBLAS} openblas)
file(COPY_FILE ${openblas} ${CPINN_OPENBLAS})
execute_process(COMMAND ${PATCHELF} --set-soname libcpinn_openblas.so ${CPINN_OPENBLAS}
    COMMAND_ERROR_IS_FATAL ANY)
set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib")

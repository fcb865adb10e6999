# cmake --install and cpack bring the program, the library with its headers, a CMake package and a
# pkg-config file, the Python package, options, reference data, the plot tool, the manual, man pages and completion.

set(data ${CMAKE_INSTALL_DATADIR}/isph)
install(TARGETS isph isph_core)
install(DIRECTORY include/isph DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES include/isph.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY options/ DESTINATION ${data}/options FILES_MATCHING PATTERN "*.opts" PATTERN "shapes/*.*")
install(DIRECTORY cases/reference/ DESTINATION ${data}/reference FILES_MATCHING PATTERN "*.csv")
install(FILES LICENSE CITATION.cff CHANGELOG.md README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})

file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/packaging)

# The Python package goes where Debian's Python looks for packages; elsewhere PYTHONPATH names the directory.
set(python_packages lib/python3/dist-packages)

# The tools in Python and their modules, with links in the directory of programs; isph-study is in the build tree too.
install(PROGRAMS studies/plot studies/isph-study DESTINATION ${data}/studies)
file(GLOB study_modules CONFIGURE_DEPENDS studies/study_*.py)
install(FILES ${study_modules} studies/balls.py studies/centreline.py studies/costs.py studies/paraview_state.py studies/runs.py
        studies/snapshot.py DESTINATION ${data}/studies)
foreach(tool IN ITEMS plot isph-study)
  string(REPLACE "isph-isph-" "isph-" link isph-${tool})
  file(RELATIVE_PATH path ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/isph/studies/${tool})
  file(CREATE_LINK ${path} ${CMAKE_BINARY_DIR}/packaging/${link} SYMBOLIC)
  install(FILES ${CMAKE_BINARY_DIR}/packaging/${link} DESTINATION ${CMAKE_INSTALL_BINDIR})
endforeach()
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/studies/isph-study ${CMAKE_BINARY_DIR}/isph-study SYMBOLIC)

include(packaging/manual.cmake)
configure_file(packaging/isph.1.in packaging/isph.1 @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/packaging/isph.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
include(packaging/isph3.cmake)
install(FILES ${CMAKE_BINARY_DIR}/packaging/isph.3 DESTINATION ${CMAKE_INSTALL_MANDIR}/man3)
install(DIRECTORY python/isph DESTINATION ${python_packages} FILES_MATCHING PATTERN "*.py")
install(FILES packaging/isph.bash RENAME isph
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

# pkg-config: what pkg-config knows is required by name; MPI may be none of them.
file(RELATIVE_PATH prefix_relative /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" prefix_relative ${prefix_relative})
set(pc_requires "PETSc >= 3.18, ${HDF5_MODULE_NAME}, muparser >= 2.3")
set(pc_cflags "")
set(pc_libs "")
set(pc_lapack "") # by names: CMake puts paths of pkg-config before the libraries
foreach(library IN LISTS LAPACK_LIBRARIES)
  get_filename_component(directory ${library} DIRECTORY)
  get_filename_component(name ${library} NAME_WE)
  string(REGEX REPLACE "^lib" "" name ${name})
  if(IS_ABSOLUTE ${library})
    string(APPEND pc_lapack " -L${directory} -l${name}")
  else()
    string(APPEND pc_lapack " ${library}")
  endif()
endforeach()
if(MPI_C_FOUND)
  foreach(directory IN LISTS MPI_C_INCLUDE_DIRS)
    string(APPEND pc_cflags " -I${directory}")
  endforeach()
  string(REPLACE ";" " " pc_libs "${MPI_C_LIBRARIES}")
else()
  string(APPEND pc_requires ", mpi-c")
endif()
configure_file(packaging/isph.pc.in packaging/isph.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/packaging/isph.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

include(CMakePackageConfigHelpers)
configure_file(packaging/isphConfig.cmake.in packaging/isphConfig.cmake @ONLY)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/packaging/isphConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/packaging/isphConfig.cmake
              ${CMAKE_BINARY_DIR}/packaging/isphConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/isph)

# cpack: a Debian package, whose dependencies follow from the libraries that the program loads.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_VENDOR "The isph authors")
set(CPACK_PACKAGE_CONTACT "The isph authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${CMAKE_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "openmpi-bin, python3-numpy, python3-h5py, python3-matplotlib")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "petsc-dev, libhdf5-mpi-dev, libmuparser-dev, paraview")
include(CPack)

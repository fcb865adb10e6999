# link_first(<program>) - names some libraries before all others, for a faster start.
#
# The dynamic linker looks for a symbol in one library after the other. Debian's PETSc and HDF5 need
# Trilinos and, through curl, OpenSSL, GnuTLS and Nettle. These libraries define half of the 51,000
# symbols of the start, and the linker finds them last: they are needed by libraries that other
# libraries need. It finds them at once if the program itself names them first, which takes 11 of 55
# ms of CPU time from each start. The program needs these libraries in any case. With a PETSc and an
# HDF5 that do without them nothing changes.
#
# PT-Scotch has the functions of Scotch, which Trilinos needs, and stays before it.
function(link_first program)
  execute_process(COMMAND ldd ${PETSC_LINK_LIBRARIES} OUTPUT_VARIABLE needed ERROR_QUIET)
  set(libraries "")
  foreach(name trilinos_teuchosparameterlist trilinos_epetra trilinos_ifpack trilinos_ml
               trilinos_teuchoscomm trilinos_epetraext ptscotch crypto gnutls nettle)
    if(needed MATCHES "=> ([^ \n]*/lib${name}[-.][^ \n]*)")
      list(APPEND libraries ${CMAKE_MATCH_1})
    endif()
  endforeach()
  if(libraries)
    target_link_libraries(${program} PRIVATE -Wl,--push-state,--no-as-needed ${libraries}
                          -Wl,--pop-state)
  endif()
endfunction()

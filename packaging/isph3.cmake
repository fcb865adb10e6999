# Writes the man page isph.3 of the functions of the library, from the comments and prototypes of include/isph.h.
file(READ ${CMAKE_SOURCE_DIR}/include/isph.h text)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/include/isph.h)
string(REGEX MATCH "^/\\*\n([^*]*)\\*/" head "${text}")
string(STRIP "${CMAKE_MATCH_1}" head)
string(REGEX REPLACE "^[^\n]*\n\n *" "" head "${head}")
string(REGEX REPLACE "\n\n +" "\n.PP\n" head "${head}")
string(REGEX REPLACE "\n +" "\n" head "${head}")
string(REPLACE ";" "\\;" text "${text}")
string(REGEX MATCHALL "/\\*[^*]*\\*/\n(PETSC_EXTERN|typedef)[^/]*\\)\\\\;" entries "${text}")
set(library_functions "")
foreach(entry IN LISTS entries)
  string(REGEX MATCH "^/\\* ([^*]*[^* ]) \\*/\n(PETSC_EXTERN )?(.*)$" found "${entry}")
  set(comment "${CMAKE_MATCH_1}")
  string(REGEX REPLACE "[ \n]+" " " prototype "${CMAKE_MATCH_3}")
  string(REGEX REPLACE "\n +" "\n" comment "${comment}")
  string(APPEND library_functions ".TP\n.B ${prototype}\n${comment}\n")
endforeach()
string(REPLACE "\\;" ";" library_functions "${library_functions}")
string(REPLACE "-" "\\-" library_functions "${library_functions}")
file(WRITE ${CMAKE_BINARY_DIR}/packaging/isph.3 ".TH ISPH 3 \"\" \"isph ${PROJECT_VERSION}\"
.SH NAME
isph \\- incompressible viscous flow by smoothed particles, on PETSc
.SH SYNOPSIS
.nf
#include <isph.h>
cc $(pkg\\-config \\-\\-cflags isph) ... $(pkg\\-config \\-\\-libs isph)
.fi
.SH DESCRIPTION
${head}
.SH FUNCTIONS
${library_functions}.SH SEE ALSO
.BR isph (1)
")

# cmake -DEXPECT=<regex> -DNP=<ranks> -P refuse.cmake -- <command>...
#
# Passes if the command is refused as a user should see it: it ends with an exit status other than 0,
# without a crash, and prints a single line that begins with "isph: " and matches EXPECT. Without
# MPI launcher stderr holds nothing else.

set(command)
set(reading FALSE)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(k RANGE ${last})
  if(reading)
    list(APPEND command "${CMAKE_ARGV${k}}")
  elseif(CMAKE_ARGV${k} STREQUAL "--")
    set(reading TRUE)
  endif()
endforeach()

execute_process(COMMAND ${command} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)

function(fail reason)
  message("${out}${err}")
  message(FATAL_ERROR "${reason}")
endfunction()

if(NOT status MATCHES "^[0-9]+$")
  fail("crashed instead of refusing: ${status}")
elseif(status EQUAL 0)
  fail("was not refused: exit status 0")
endif()

# The text is read line by line and not as a list, because an error line may hold any character.
set(errors 0)
set(text "\n${out}\n${err}\n")
while(text MATCHES "\n(isph: [^\n]*)\n")
  set(error "${CMAKE_MATCH_1}")
  math(EXPR errors "${errors} + 1")
  string(FIND "${text}" "\n${error}\n" at)
  string(LENGTH "\n${error}" length)
  math(EXPR at "${at} + ${length}")
  string(SUBSTRING "${text}" ${at} -1 text)
endwhile()

if(NOT errors EQUAL 1)
  fail("${errors} lines begin with 'isph: '; exactly one is allowed")
elseif(NOT error MATCHES "${EXPECT}")
  fail("the error line does not match '${EXPECT}':\n${error}")
elseif("${out}${err}" MATCHES "PETSC ERROR|Sanitizer|runtime error:")
  fail("a traceback stands beside the error line")
elseif(NP EQUAL 1)
  string(REPLACE "${error}" "" rest "${err}")
  string(STRIP "${rest}" rest)
  if(NOT rest STREQUAL "")
    fail("stderr holds more than the error line:\n${rest}")
  endif()
endif()
message("refused with status ${status}: ${error}")

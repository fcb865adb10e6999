# cmake -DISPH=<program> -DREADME=<file> -P readme.cmake
#
# Passes if README.md contains the output of `isph -catalogue`.

execute_process(COMMAND ${ISPH} -catalogue OUTPUT_VARIABLE catalogue RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "isph -catalogue ended with ${status}")
endif()
file(READ ${README} readme)
string(FIND "${readme}" "${catalogue}" position)
if(position EQUAL -1)
  message(FATAL_ERROR "README.md does not hold the present output of `isph -catalogue`")
endif()

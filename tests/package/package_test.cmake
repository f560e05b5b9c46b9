# Run by CTest: see CMakeLists.txt for the variables.

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect what)
  if(NOT (${ARGN}))
    message(SEND_ERROR "expected ${what}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
set(prefix "${WORK_DIR}/moved prefix")  # with a space, and not where it was installed to

run("installing" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
file(RENAME ${WORK_DIR}/prefix "${prefix}")

# 1. What has to be there.
foreach(file IN ITEMS
    parameter_sets/set1.toml parameter_sets/set2.toml
    freight/empty.toml geometry/nominal-1435.toml wagons/hbbills311.toml)
  expect("${file} in the installed tree" EXISTS "${prefix}/share/uiclink/${file}")
endforeach()
if(PROGRAMS)
  run("the alias of identify" "${prefix}/bin/uiclink-identify" --version)
  # A program finds its data beside itself, wherever the tree was moved to.
  run("the installed wagon" ${CMAKE_COMMAND} -E env --unset=UICLINK_DATA "${prefix}/bin/wagon" inertia --cargo empty --json -)
  string(FIND "${output}" "\"${prefix}/share/uiclink/freight/empty.toml\"" position)
  expect("the installed freight in:\n${output}" NOT position EQUAL -1)
endif()

# 2. What must not be there: this machine's folders, and the warnings of our own code.
file(GLOB_RECURSE package_files "${prefix}/*.cmake")
expect("a package configuration" package_files)
foreach(file IN LISTS package_files)
  file(READ "${file}" text)
  foreach(word IN ITEMS "${SOURCE_DIR}" "${BUILD_DIR}" uiclink_warnings -Wall)
    string(FIND "${text}" "${word}" position)
    expect("no '${word}' in ${file}" position EQUAL -1)
  endforeach()
endforeach()

# 3. A program of ten lines, and one that includes every installed header.
run("configuring the program" ${CMAKE_COMMAND}
  -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${WORK_DIR}/build -G ${GENERATOR}
  "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_BUILD_TYPE=${BUILD_TYPE}
  -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}")
run("building the program" ${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run("running the program" ${WORK_DIR}/build/consumer)
expect("'k k1 T01' from the program, found '${output}'" output STREQUAL "k k1 T01\n")

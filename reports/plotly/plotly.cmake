# Fetches Plotly from the npm registry into the build tree (`npm ci`: what package-lock.json says, checked by its
# checksum) and sets plotly_bundle and plotly_license to its files: empty ones where it cannot be had. A build needs
# neither Node.js nor a network; configuring says what the pages will lack, and tries again next time.

option(UICLINK_PLOTLY "Interactive charts in HTML pages (Plotly, from the npm registry)" ON)

set(plotly_folder ${CMAKE_CURRENT_BINARY_DIR}/plotly)
set(plotly_bundle ${plotly_folder}/bundle.js)
set(plotly_license ${plotly_folder}/LICENSE)
set(plotly_lock ${CMAKE_CURRENT_LIST_DIR}/package-lock.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${plotly_lock} ${CMAKE_CURRENT_LIST_DIR}/package.json)

# Why there is no bundle in plotly_folder now; empty if there is.
function(uiclink_fetch_plotly why)
  find_program(UICLINK_NPM npm)
  if(NOT UICLINK_NPM)
    set(${why} "npm was not found (Debian package npm)" PARENT_SCOPE)
    return()
  endif()
  file(COPY ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/package.json ${plotly_lock} DESTINATION ${plotly_folder})
  execute_process(
    COMMAND ${UICLINK_NPM} ci --ignore-scripts --no-audit --no-fund --no-update-notifier --prefer-offline
            --fetch-retries=1 --fetch-retry-mintimeout=2000 --fetch-timeout=60000
    WORKING_DIRECTORY ${plotly_folder}
    OUTPUT_FILE ${plotly_folder}/npm.log
    ERROR_FILE ${plotly_folder}/npm.log
    RESULT_VARIABLE result)
  set(package ${plotly_folder}/node_modules/plotly.js-cartesian-dist-min)
  if(NOT result EQUAL 0 OR NOT EXISTS ${package}/plotly-cartesian.min.js OR NOT EXISTS ${package}/LICENSE)
    set(${why} "npm could not install it (${plotly_folder}/npm.log)" PARENT_SCOPE)
    return()
  endif()
  file(COPY_FILE ${package}/plotly-cartesian.min.js ${plotly_bundle} ONLY_IF_DIFFERENT)
  file(COPY_FILE ${package}/LICENSE ${plotly_license} ONLY_IF_DIFFERENT)
  set(${why} "" PARENT_SCOPE)
endfunction()

# The bundle in plotly_folder is that of this checksum of the lock file.
file(SHA256 ${plotly_lock} plotly_wanted)
set(plotly_had "")
if(EXISTS ${plotly_folder}/fetched)
  file(READ ${plotly_folder}/fetched plotly_had)
endif()
set(plotly_missing "")
if(NOT UICLINK_PLOTLY)
  set(plotly_missing "UICLINK_PLOTLY is off")
elseif(NOT plotly_had STREQUAL plotly_wanted)
  uiclink_fetch_plotly(plotly_missing)
endif()

if(plotly_missing)
  message(STATUS "Plotly: none, ${plotly_missing}. HTML pages will have gnuplot's pictures instead of charts.")
  file(CONFIGURE OUTPUT ${plotly_bundle} CONTENT "")
  file(CONFIGURE OUTPUT ${plotly_license} CONTENT "")
  file(REMOVE ${plotly_folder}/fetched)
  set(UICLINK_HAS_PLOTLY OFF CACHE INTERNAL "HTML pages have charts")
else()
  file(SIZE ${plotly_bundle} plotly_size)
  message(STATUS "Plotly: embedded in HTML pages (${plotly_size} bytes)")
  file(WRITE ${plotly_folder}/fetched ${plotly_wanted})
  set(UICLINK_HAS_PLOTLY ON CACHE INTERNAL "HTML pages have charts")
endif()

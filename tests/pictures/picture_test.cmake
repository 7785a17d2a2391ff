# Renders one picture with the shipped program under each back end, checks it, and holds the back ends against each other.
# cmake -DPROGRAM= -DCHECK= -DFOLDER= -DNAME= -DSIZE= -DLIT= -DDISTANCE= [-DEV=] "-DARGUMENTS=a;b" -P picture_test.cmake
# What it renders stays in FOLDER, for a look at a picture that failed.
file(MAKE_DIRECTORY ${FOLDER})

foreach(backend none egl osmesa)
  set(picture ${FOLDER}/${NAME}-${backend}.exr)
  set(facts ${FOLDER}/${NAME}-${backend}.json)
  file(REMOVE ${picture} ${facts})
  execute_process(COMMAND ${PROGRAM} render ${ARGUMENTS} --size ${SIZE} --backend ${backend} -o ${picture} --json ${facts}
                  RESULT_VARIABLE code ERROR_VARIABLE messages)
  if(backend STREQUAL "osmesa" AND code EQUAL 4)
    message("OSMesa is not on this machine; skipped")
    continue()
  endif()
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${backend}: exit code ${code}\n${messages}")
  endif()

  file(READ ${facts} json)
  string(JSON used GET "${json}" gl backend)
  if(NOT used MATCHES "^${backend}")
    message(FATAL_ERROR "asked for ${backend}, the report says ${used}")
  endif()
  string(JSON nan_samples GET "${json}" nan_samples)
  if(NOT nan_samples EQUAL 0)
    message(FATAL_ERROR "${backend}: ${nan_samples} samples were not finite")
  endif()

  execute_process(COMMAND ${CHECK} ${picture} ${SIZE} ${LIT} ${EV} RESULT_VARIABLE code COMMAND_ECHO STDOUT)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${backend}: the picture is wrong")
  endif()
  if(NOT backend STREQUAL "none")
    execute_process(COMMAND ${PROGRAM} error ${picture} ${FOLDER}/${NAME}-none.exr --fail-above smape=${DISTANCE}
                    RESULT_VARIABLE code COMMAND_ECHO STDOUT)
    if(NOT code EQUAL 0)
      message(FATAL_ERROR "${backend} differs from the picture by rays")
    endif()
  endif()
endforeach()

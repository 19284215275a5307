# Copies into /etc/contourd what is not there yet. What is there stays as it is: the owner may have edited it.
# `shipped` is the installed folder that it is copied from, without DESTDIR.
set(etc "$ENV{DESTDIR}/etc/contourd")
file(GLOB_RECURSE files RELATIVE "$ENV{DESTDIR}${shipped}" "$ENV{DESTDIR}${shipped}/*.json")
foreach(file ${files})
  if(file MATCHES "^raspberry-pi-")  # examples
    continue()
  elseif(EXISTS "${etc}/${file}" OR IS_SYMLINK "${etc}/${file}")
    message(STATUS "Left as it is: ${etc}/${file}")
  elseif(file MATCHES "[.]schema[.]json$")  # so that it is always the program's, and an editor finds it
    file(MAKE_DIRECTORY "${etc}")
    file(CREATE_LINK "${shipped}/${file}" "${etc}/${file}" SYMBOLIC)
  else()
    message(STATUS "Copying to: ${etc}/${file}")
    configure_file("$ENV{DESTDIR}${shipped}/${file}" "${etc}/${file}" COPYONLY)
  endif()
endforeach()

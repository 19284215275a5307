# Copies missing files to /etc/contourd. Existing files are not changed, since the user may have edited them.
# `shipped` is the installed folder with the originals, without DESTDIR.
set(etc "$ENV{DESTDIR}/etc/contourd")
file(GLOB_RECURSE files RELATIVE "$ENV{DESTDIR}${shipped}" "$ENV{DESTDIR}${shipped}/*.json")
foreach(file ${files})
  if(file MATCHES "^raspberry-pi-")  # examples
    continue()
  elseif(EXISTS "${etc}/${file}" OR IS_SYMLINK "${etc}/${file}")
    message(STATUS "Keeping: ${etc}/${file}")
  elseif(file MATCHES "[.]schema[.]json$")  # a link always leads to the program's present schema, and editors find it
    file(MAKE_DIRECTORY "${etc}")
    file(CREATE_LINK "${shipped}/${file}" "${etc}/${file}" SYMBOLIC)
  else()
    message(STATUS "Copying to: ${etc}/${file}")
    configure_file("$ENV{DESTDIR}${shipped}/${file}" "${etc}/${file}" COPYONLY)
  endif()
endforeach()

# Removes what the last installation from this build put there: `manifest` names the files. /etc/contourd and the spool
# are the owner's, and stay.
if(NOT EXISTS "${manifest}")
  message(FATAL_ERROR "There is nothing to remove: ${manifest} is not there, so nothing was installed from this build")
endif()
file(STRINGS "${manifest}" files)
foreach(file ${files})
  if(EXISTS "$ENV{DESTDIR}${file}" OR IS_SYMLINK "$ENV{DESTDIR}${file}")
    message(STATUS "Removing: $ENV{DESTDIR}${file}")
    file(REMOVE "$ENV{DESTDIR}${file}")
  endif()
endforeach()
message(STATUS "Kept: /etc/contourd, /var/spool/contourd, /var/lib/contourd")

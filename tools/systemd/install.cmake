# Installs the systemd units for the programs in PREFIX/bin, the user that they run as, and default options for each node:
#   DESTDIR=... cmake -DCMAKE_INSTALL_PREFIX=PREFIX -P tools/systemd/install.cmake
# cmake --install runs it, too. Files in /etc/multireach, which are the user's, override the defaults.
set(from "${CMAKE_CURRENT_LIST_DIR}")
file(GLOB units RELATIVE "${from}" "${from}/*.service" "${from}/*.target" "${from}/*.service.d/*.conf")
foreach(unit IN LISTS units)
  file(READ "${from}/${unit}" text)
  string(REPLACE "/usr/local/" "${CMAKE_INSTALL_PREFIX}/" text "${text}")
  set(target "${CMAKE_INSTALL_PREFIX}/lib/systemd/system/${unit}")
  file(WRITE "$ENV{DESTDIR}${target}" "${text}")
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES "${target}")
  message(STATUS "Installing: $ENV{DESTDIR}${target}")
endforeach()
file(GLOB options "${from}/config/*.env")
file(INSTALL ${options} DESTINATION "${CMAKE_INSTALL_PREFIX}/share/multireach/systemd")
file(INSTALL "${from}/multireach.sysusers" DESTINATION "${CMAKE_INSTALL_PREFIX}/lib/sysusers.d" RENAME multireach.conf)

# What `cmake --install` installs besides the libraries (multireach_stage) and programs (multireach_program) of cmake/options.cmake.
# Components: programs, camera, development, python: one Debian package each, see packages.cmake.
set(data_dir ${CMAKE_INSTALL_DATADIR}/multireach)
# Scripts, in a folder of their own with what only they use, and a command for each that a user calls.
set(script_dir lib/multireach)
install(PROGRAMS tools/launch.sh tools/doctor.sh tools/spy.sh tools/multireach DESTINATION ${script_dir} COMPONENT programs)
install(FILES tools/location.sh tools/groups.sh tools/recorder.sh tools/supervisor.sh DESTINATION ${script_dir} COMPONENT programs)
install(TARGETS multireach-datagram-guard LIBRARY DESTINATION ${script_dir} COMPONENT programs)
install(CODE [[
  set(folder "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin")
  file(MAKE_DIRECTORY "${folder}")
  foreach(link multireach-launch=launch.sh multireach-doctor=doctor.sh multireach-spy=spy.sh multireach=multireach)
    string(REPLACE "=" ";" link "${link}")
    list(GET link 0 name)
    list(GET link 1 script)
    message(STATUS "Installing: ${folder}/${name}")
    file(CREATE_LINK "../lib/multireach/${script}" "${folder}/${name}" SYMBOLIC)
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES "${CMAKE_INSTALL_PREFIX}/bin/${name}")
  endforeach()
]] COMPONENT programs)
install(SCRIPT tools/systemd/install.cmake COMPONENT programs)

install(DIRECTORY robots DESTINATION ${data_dir} COMPONENT programs)
install(FILES logs/reach.lcm logs/reach.yaml logs/load.yaml DESTINATION ${data_dir}/logs COMPONENT programs)
install(DIRECTORY examples/tag DESTINATION ${data_dir}/examples COMPONENT programs)
install(DIRECTORY lcmtypes DESTINATION ${data_dir} COMPONENT programs FILES_MATCHING PATTERN "*.lcm")
install(FILES "${CMAKE_BINARY_DIR}/multireach-types.jar" DESTINATION ${data_dir} COMPONENT programs OPTIONAL)
# web/build.sh writes the page beside the builds.
install(DIRECTORY "${PROJECT_SOURCE_DIR}/build/web" DESTINATION ${data_dir} COMPONENT programs OPTIONAL)

# Man pages and completion, from what the programs print for --help.
find_program(DEBIAN_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(DEBIAN_PYTHON)
  set(pages "${CMAKE_BINARY_DIR}/pages")
  get_property(programs GLOBAL PROPERTY multireach_programs)
  set(commands "")
  foreach(program IN LISTS programs)
    list(APPEND commands "$<TARGET_FILE:${program}>")
  endforeach()
  list(APPEND commands tools/multireach tools/launch.sh=multireach-launch tools/doctor.sh=multireach-doctor tools/spy.sh=multireach-spy)
  add_custom_command(OUTPUT "${pages}/made"
    COMMAND "${DEBIAN_PYTHON}" tools/program_pages.py "${pages}" ${PROJECT_VERSION} ${commands}
    COMMAND "${CMAKE_COMMAND}" -E touch "${pages}/made"
    DEPENDS ${programs} tools/program_pages.py tools/multireach tools/launch.sh tools/doctor.sh tools/spy.sh
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" COMMENT "man pages and bash completion" VERBATIM)
  add_custom_target(multireach_pages ALL DEPENDS "${pages}/made")
  foreach(folder "man/;${CMAKE_INSTALL_MANDIR}/man1" "completions/;${CMAKE_INSTALL_DATADIR}/bash-completion/completions")
    list(GET folder 0 from)
    list(GET folder 1 to)
    set(of_camera PATTERN "multireach-camera*" PATTERN "multireach-calibrate*" PATTERN "multireach-videos*")
    install(DIRECTORY "${pages}/${from}" DESTINATION ${to} COMPONENT programs PATTERN "multireach-camera*" EXCLUDE
      PATTERN "multireach-calibrate*" EXCLUDE PATTERN "multireach-videos*" EXCLUDE)
    install(DIRECTORY "${pages}/${from}" DESTINATION ${to} COMPONENT camera FILES_MATCHING ${of_camera})
  endforeach()
endif()
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs FILES_MATCHING PATTERN "*.md")
# The generated C++ messages, whose decoders are safe: multireach::lcmtypes.
install(DIRECTORY "${CMAKE_BINARY_DIR}/lcmtypes/include/multireach" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
  FILES_MATCHING PATTERN "*.hpp")

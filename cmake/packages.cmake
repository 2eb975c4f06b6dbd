# Debian packages of what is installed, made by tools/package.sh: multireach, multireach-camera, libmultireach-dev,
# python3-multireach.
set(CPACK_GENERATOR DEB)
set(CPACK_VERBATIM_VARIABLES YES)
set(CPACK_PACKAGE_NAME multireach)
set(CPACK_PACKAGE_VENDOR multireach)
set(MULTIREACH_MAINTAINER "The multireach authors <multireach@localhost>" CACHE STRING "Who answers for the Debian packages")
set(CPACK_PACKAGE_CONTACT "${MULTIREACH_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL "")

# The changelog of all packages, and debian/copyright.
set(debian "${CMAKE_BINARY_DIR}/debian")
execute_process(COMMAND git log -1 --format=%cD WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE date
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT date)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
file(CONFIGURE OUTPUT "${debian}/changelog" @ONLY CONTENT "multireach (@PROJECT_VERSION@) bookworm; urgency=medium

  * See /usr/share/doc/multireach/CHANGELOG.md.

 -- @CPACK_PACKAGE_CONTACT@  @date@
")
file(STRINGS "${PROJECT_SOURCE_DIR}/LICENSE" lines)
set(copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: multireach\n\nFiles: *\nLicense: BSD-3-Clause\n")
foreach(line IN LISTS lines)
  if(line MATCHES "^Copyright \\(c\\) (.*)$")
    string(REPLACE "License: BSD" "Copyright: ${CMAKE_MATCH_1}\nLicense: BSD" copyright "${copyright}")
  elseif(line MATCHES "^ *$")
    string(APPEND copyright " .\n")
  elseif(NOT line MATCHES "^BSD 3-Clause License")
    string(APPEND copyright " ${line}\n")
  endif()
endforeach()
file(CONFIGURE OUTPUT "${debian}/copyright" CONTENT "${copyright}" @ONLY)
execute_process(COMMAND gzip -9nf "${debian}/changelog")

# multireach_package(COMPONENT NAME SECTION DEPENDS TITLE TEXT): a package of what an install component holds.
macro(multireach_package component name section depends title text)
  install(FILES "${debian}/changelog.gz" "${debian}/copyright" DESTINATION share/doc/${name} COMPONENT ${component})
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${title}\n${text}")
endmacro()

# What the programs link is found by dpkg-shlibdeps; the scripts need ip, lcm-logger and lcm-logplayer.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "liblcm-java, libjchart2d-java, default-jre, gnuplot-nox, bash-completion")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "multireach-camera")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/cmake/debian/postinst;${PROJECT_SOURCE_DIR}/cmake/debian/prerm;${PROJECT_SOURCE_DIR}/cmake/debian/postrm")
multireach_package(programs multireach science "iproute2, liblcm-bin"
  "from two camera images to a reaching robot arm, over LCM"
  "Separate processes see a coloured ball or an AprilTag with two cameras,
compute the motion of an arm by multi-referential dynamical systems (Hersch
and Billard, 2008), and command the robot, or a simulated one, at 1 kHz. With
programs that record, inspect, replay and show runs, and seven arms.")

# A package of its own: OpenCV's highgui and videoio bring Qt and all of FFmpeg, 120 MB.
if(TARGET multireach-camera OR TARGET multireach-calibrate)
  set(CPACK_DEBIAN_CAMERA_PACKAGE_SHLIBDEPS ON)
  multireach_package(camera multireach-camera science "multireach (= ${PROJECT_VERSION})"
    "cameras of multireach: capture, rendered scenes, calibration"
    "multireach-camera reads two cameras, videos or image files, or renders scenes;
multireach-calibrate finds the cameras' parameters, their poses relative to
the robot, and the colours of targets; multireach-videos imports two videos.")
endif()

# CMake and pkg-config files name all libraries: they are static.
multireach_package(development libmultireach-dev libdevel
  "libeigen3-dev, libfcl-dev, libhwy-dev, libtinyxml2-dev, liburdfdom-dev, libconsole-bridge-dev, libopencv-core-dev, libopencv-imgproc-dev, libturbojpeg0-dev, libjpeg62-turbo-dev, libapriltag-dev"
  "vision, reaching controller and bridge of multireach (libraries)"
  "C++ libraries without LCM, clock or thread: arms from URDF, inverse
kinematics, the reaching controller, stereo tracking, and motion within
limits; and the C++ messages of multireach. For CMake there is
find_package(multireach), for others pkg-config.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "liblcm-dev, cmake, pkgconf")

if(MULTIREACH_PYTHON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/cmake/debian/python/prerm")
  multireach_package(python python3-multireach python "python3 (>= 3.11), python3 (<< 3.12), python3-numpy"
    "arms, reaching controller, vision and logs of multireach (Python)"
    "NumPy arrays in and out: kinematics of arms from URDF, the reaching
controller step by step and in batches, stereo tracking, recorded logs, and
LCM messages.")
endif()
include(CPack)

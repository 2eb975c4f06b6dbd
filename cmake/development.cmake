# What `cmake --install` installs for those who build on the libraries: cmake/multireach-config.cmake says what each component needs. For
# other build systems, pkg-config files of the libraries that move arms, and of those that see; the libraries are static, so that what
# they need is linked too. Included once the dependencies are found.
include(CMakePackageConfigHelpers)
write_basic_package_version_file("${CMAKE_BINARY_DIR}/multireach-config-version.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_SOURCE_DIR}/cmake/multireach-config.cmake" "${PROJECT_SOURCE_DIR}/cmake/opencv.cmake"
  "${CMAKE_BINARY_DIR}/multireach-config-version.cmake"
  DESTINATION ${multireach_package_dir} COMPONENT development)
string(REGEX REPLACE "[^/]+" ".." up_to_prefix "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
set(pc_suffix "")
set(pc_description "Arms from URDF, the reaching controller, and the bridge to 1 kHz commands")
set(pc_requires "eigen3 fcl libhwy tinyxml2 urdfdom")
set(pc_cflags "")
set(pc_libs "-lmultireach_controller_batch -lmultireach_controller -lmultireach_robot_bridge -lmultireach_kinematics -lmultireach_numeric -lconsole_bridge")
configure_file(cmake/multireach.pc.in "${CMAKE_BINARY_DIR}/multireach.pc" @ONLY)
set(pc_suffix "-vision")
set(pc_description "Stereo tracking of coloured objects and AprilTags")
set(pc_requires "multireach apriltag libjpeg libturbojpeg")
set(pc_cflags " -I${OPENCV_INCLUDE}")
set(pc_libs "-lmultireach_vision -lmultireach_imaging -lopencv_imgproc -lopencv_core")
configure_file(cmake/multireach.pc.in "${CMAKE_BINARY_DIR}/multireach-vision.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/multireach.pc" "${CMAKE_BINARY_DIR}/multireach-vision.pc"
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

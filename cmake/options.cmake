# Warnings, floating-point rules and sanitizers, for every target of the project.
add_library(multireach_options INTERFACE)
target_compile_options(multireach_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wunused)
# Formulas over lanes combine masks with & and |; for one lane a mask is a bool.
target_compile_options(multireach_options INTERFACE $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>)
if(MULTIREACH_WERROR)
  target_compile_options(multireach_options INTERFACE -Werror)
endif()

# The same source must give the same bits under any compiler and optimisation: no fused multiply-adds chosen by the
# compiler, and never -ffast-math.
target_compile_options(multireach_options INTERFACE -ffp-contract=off)

if(MULTIREACH_SANITIZE)
  target_compile_options(multireach_options INTERFACE -fsanitize=${MULTIREACH_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  # The sanitizers' own code makes GCC see uninitialised values that are none.
  target_compile_options(multireach_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(multireach_options INTERFACE -fsanitize=${MULTIREACH_SANITIZE})
endif()
if(MULTIREACH_FUZZERS)
  # Counts of visited code, which lead libFuzzer to inputs that reach more of it.
  target_compile_options(multireach_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

set(multireach_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/multireach)
# multireach_stage(NAME [SOURCES...]) makes the library multireach::NAME from this folder (header-only without sources) and installs
# it with its headers, for find_package(multireach COMPONENTS NAME). What lies in node/, sim/ or drivers/ is not part of it.
function(multireach_stage name)
  if(ARGN)
    set(scope PUBLIC)
    add_library(multireach_${name} STATIC ${ARGN})
    target_link_libraries(multireach_${name} PRIVATE $<BUILD_INTERFACE:multireach_options>)
  else()
    set(scope INTERFACE)
    add_library(multireach_${name} INTERFACE)
  endif()
  add_library(multireach::${name} ALIAS multireach_${name})
  set_target_properties(multireach_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(multireach_${name} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/multireach>)
  target_compile_features(multireach_${name} ${scope} cxx_std_20)
  install(TARGETS multireach_${name} EXPORT multireach-${name} COMPONENT development)
  install(EXPORT multireach-${name} NAMESPACE multireach:: DESTINATION ${multireach_package_dir} COMPONENT development)
  get_filename_component(folder "${CMAKE_CURRENT_SOURCE_DIR}" NAME)
  install(DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}/" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/multireach/${folder}
    COMPONENT development FILES_MATCHING PATTERN "*.hpp"
    PATTERN node EXCLUDE PATTERN sim EXCLUDE PATTERN drivers EXCLUDE)
endfunction()

# multireach_program(NAME FOLDER [LIBRARIES...] [COMPONENT C]) makes the program multireach-NAME from FOLDER/main.cpp, and from the other sources
# of FOLDER and the folders in EXTRA_FOLDERS the library multireach_NAME_parts (dashes become underscores), which tests, benchmarks
# and other programs use too. It is installed with the component `programs`, or C.
function(multireach_program name folder)
  cmake_parse_arguments(arg "" "COMPONENT" "EXTRA_FOLDERS" ${ARGN})
  string(REPLACE "-" "_" parts "multireach_${name}_parts")
  set(sources)
  foreach(each ${folder} ${arg_EXTRA_FOLDERS})
    file(GLOB found CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${each}/*.cpp")
    list(APPEND sources ${found})
  endforeach()
  list(REMOVE_ITEM sources "${CMAKE_CURRENT_SOURCE_DIR}/${folder}/main.cpp")
  set(libraries multireach_runtime ${arg_UNPARSED_ARGUMENTS})
  if(sources)
    add_library(${parts} STATIC ${sources})
    target_link_libraries(${parts} PUBLIC ${libraries} PRIVATE multireach_options)
    set(libraries ${parts})
  endif()
  add_executable(multireach-${name} ${folder}/main.cpp)
  target_link_libraries(multireach-${name} PRIVATE ${libraries} multireach_options)
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT programs)
  endif()
  install(TARGETS multireach-${name} COMPONENT ${arg_COMPONENT})
  set_property(GLOBAL APPEND PROPERTY multireach_programs multireach-${name})
endfunction()

# multireach_lanes(TARGET): its sources that Highway compiles once for each instruction set are compiled for 2 lanes (SSE4,
# NEON), 4 (AVX2) and 8 (AVX-512), and for one, for what is older.
function(multireach_lanes target)
  target_link_libraries(${target} PRIVATE hwy::hwy)
  target_compile_definitions(${target} PRIVATE
    "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_AVX3_DL|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)")
  # Loops over the joints, whose number the compiler knows, and over the rows of small matrices are worth unrolling.
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # Where that number is open, GCC then thinks of what is not read: the rows of an arm without joints.
    target_compile_options(${target} PRIVATE --param=max-completely-peeled-insns=4000 --param=max-completely-peel-times=32
      -Wno-maybe-uninitialized)
  endif()
endfunction()

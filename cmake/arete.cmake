# Compile settings as an interface target: no global flags.
add_library(arete_settings INTERFACE)
target_compile_features(arete_settings INTERFACE cxx_std_20)
# No contraction: what is computed in two places must agree bit by bit, such as the status of a
# vertex by either of its triangles.
target_compile_options(arete_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wold-style-cast -Wnon-virtual-dtor
  -Woverloaded-virtual -ffp-contract=off
  $<$<BOOL:${ARETE_WARNINGS_AS_ERRORS}>:-Werror>)
target_compile_definitions(arete_settings INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_XYZW_ONLY)
if(ARETE_SANITIZE)
  # GCC 12 sees uninitialised members in std::regex once it is instrumented; the plain builds still
  # warn.
  target_compile_options(arete_settings INTERFACE -fsanitize=${ARETE_SANITIZE}
    -fno-sanitize-recover=all -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(arete_settings INTERFACE -fsanitize=${ARETE_SANITIZE})
endif()
if(ARETE_COVERAGE)
  target_compile_options(arete_settings INTERFACE --coverage)
  target_link_options(arete_settings INTERFACE --coverage)
endif()

# arete_room(NAME [SOURCES ...] [ROOMS ...] [PACKAGES ...]): the static library arete::NAME.
# ROOMS are linked PUBLIC, PACKAGES PRIVATE.
function(arete_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;ROOMS;PACKAGES" ${ARGN})
  add_library(arete_${name} STATIC ${ROOM_SOURCES})
  add_library(arete::${name} ALIAS arete_${name})
  target_include_directories(arete_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(arete_${name} PRIVATE arete_settings ${ROOM_PACKAGES})
  foreach(room ${ROOM_ROOMS})
    target_link_libraries(arete_${name} PUBLIC arete::${room})
  endforeach()
endfunction()

# arete_test(NAME SOURCES ... ROOMS ...): one GoogleTest binary, registered test by test.
function(arete_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;ROOMS;PACKAGES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name}
    PRIVATE arete_settings GTest::gtest_main GTest::gmock ${TEST_PACKAGES})
  foreach(room ${TEST_ROOMS})
    target_link_libraries(${name} PRIVATE arete::${room})
  endforeach()
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()

# Lets an ordinary ament_cmake package build on ROS 2 installed from wheels. Included right after project() by CMAKE_PROJECT_INCLUDE;
# on an installed ROS 2 distribution nothing includes it.

find_package(Python3 REQUIRED COMPONENTS Interpreter)

# The prefix that holds ament: the environment itself, or the isolated build environment of pip.
execute_process(
  COMMAND "${Python3_EXECUTABLE}" -c "import ament_package, pathlib; print(pathlib.Path(ament_package.__file__).parents[4].as_posix())"
  OUTPUT_VARIABLE ros_wheels_prefix
  OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
list(PREPEND CMAKE_PREFIX_PATH "${ros_wheels_prefix}")
set(ENV{AMENT_PREFIX_PATH} "${ros_wheels_prefix}")

# The wheels name include directories of the machine that built them; CMake refuses imported targets whose directories do not exist.
function(drop_absent_include_directories)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(include_directories ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(include_directories)
      list(FILTER include_directories EXCLUDE REGEX "^/opt/python/")
      set_property(TARGET ${target} PROPERTY INTERFACE_INCLUDE_DIRECTORIES "${include_directories}")
    endif()
  endforeach()
endfunction()
cmake_language(DEFER CALL drop_absent_include_directories) # once the package has found all that it needs

# Each interface is parsed by the first of the generators that comes to it, see parse_once.py.
set(parse_once "${CMAKE_BINARY_DIR}/parse_once")
file(MAKE_DIRECTORY "${parse_once}/parsed")
file(CONFIGURE OUTPUT "${parse_once}/python" CONTENT "#!/bin/sh\nexec '@Python3_EXECUTABLE@' '@CMAKE_CURRENT_LIST_DIR@/parse_once.py' '@parse_once@/parsed' \"$@\"\n" @ONLY)
file(CHMOD "${parse_once}/python" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
set_property(TARGET Python3::Interpreter PROPERTY IMPORTED_LOCATION "${parse_once}/python")

if(SKBUILD)
  include("${CMAKE_CURRENT_LIST_DIR}/install_node_packages.cmake")
  include("${CMAKE_CURRENT_LIST_DIR}/../core/library.cmake")
endif()

# Most of the time of the build is the same headers compiled for each message anew: the C++ sources are compiled in batches.
# A message that holds others of the package is compiled alone: in a batch it would use their type support before it is defined.
function(compile_holders_alone target)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "/(beliefs|controller_state|design_arrays)__")
  set_source_files_properties(${sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

function(compile_type_support_in_batches)
  foreach(kind IN ITEMS typesupport_fastrtps_c typesupport_fastrtps_cpp typesupport_introspection_cpp typesupport_cpp)
    if(TARGET ${PROJECT_NAME}__rosidl_${kind})
      set_target_properties(${PROJECT_NAME}__rosidl_${kind} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
      compile_holders_alone(${PROJECT_NAME}__rosidl_${kind})
    endif()
  endforeach()
endfunction()
cmake_language(DEFER CALL compile_type_support_in_batches)

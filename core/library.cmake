# The library of the core, for the package of colcon (CMakeLists.txt) and for the wheel (cmake/ros_wheels.cmake).
set(heave_core_folder "${CMAKE_CURRENT_LIST_DIR}")
set(heave_core_made "${CMAKE_CURRENT_BINARY_DIR}/heave_core")
file(MAKE_DIRECTORY "${heave_core_made}")
find_package(Python3 REQUIRED COMPONENTS Interpreter)

file(GLOB heave_core_sources CONFIGURE_DEPENDS "${heave_core_folder}/heave_core/src/*.cpp")
file(GLOB heave_core_tables CONFIGURE_DEPENDS "${heave_core_folder}/heave_core/*.py")

# One table makes the C++ header here, and the numpy types in Python.
add_custom_command(
  OUTPUT "${heave_core_made}/layout.h"
  COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${heave_core_folder}" PYTHONDONTWRITEBYTECODE=1
    "${Python3_EXECUTABLE}" -m heave_core.layout > "${heave_core_made}/layout.h"
  DEPENDS ${heave_core_tables} "${heave_core_folder}/heave_core/src/interface.cpp"
  VERBATIM)

add_library(heave_core SHARED
  ${heave_core_sources}
  "${heave_core_made}/layout.h")
target_include_directories(heave_core PRIVATE "${heave_core_made}" "${heave_core_folder}/heave_core/src")
target_compile_features(heave_core PRIVATE cxx_std_17)
# The same bits as numpy: no fused multiply-add.
target_compile_options(heave_core PRIVATE
  -O3 -Wall -Wextra -Werror -ffp-contract=off -fno-exceptions -fno-rtti)
install(TARGETS heave_core LIBRARY DESTINATION lib)

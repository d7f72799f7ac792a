# Gives a pip installation what colcon would give: for each Python package its mark in the ament index, package.xml, launch files,
# configuration, and lib/PACKAGE/EXECUTABLE, by which `ros2 run` and `ros2 launch` start nodes.

set(repository "${CMAKE_CURRENT_LIST_DIR}/..")

# install_node_package(FOLDER PACKAGE [EXECUTABLE...])
function(install_node_package folder package)
  install(FILES "${repository}/${folder}/resource/${package}" DESTINATION share/ament_index/resource_index/packages)
  install(FILES "${repository}/${folder}/package.xml" DESTINATION share/${package})
  foreach(data IN ITEMS launch config)
    if(IS_DIRECTORY "${repository}/${folder}/${data}")
      install(DIRECTORY "${repository}/${folder}/${data}" DESTINATION share/${package} PATTERN "__pycache__" EXCLUDE)
    endif()
  endforeach()
  foreach(executable IN LISTS ARGN)
    set(script "${CMAKE_CURRENT_BINARY_DIR}/node_executables/${package}/${executable}")
    file(WRITE "${script}" "#!/bin/sh\nexec \"$(dirname \"$0\")/../../bin/${executable}\" \"$@\"\n")
    install(PROGRAMS "${script}" DESTINATION lib/${package})
  endforeach()
endfunction()

install_node_package(node_base heave_node)
install_node_package(wave_vessel_node wave_vessel_node wave_vessel)
install_node_package(cable_sim_node cable_sim_node cable_sim virtual_winch)
install_node_package(winch_controller_node winch_controller_node winch_controller winch_adviser)
install_node_package(bags heave_bags recorder player)
install_node_package(bringup heave_bringup heave ship_clock)

# `cmake -D NM=… -D LIBRARY=… -P vector_clones.cmake`: checks that the library contains AVX2 clones of the hot loops. In some
# cases GCC 12 omits clones of templates without a warning.
execute_process(COMMAND ${NM} -C ${LIBRARY} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
foreach(cables 4 8 -1)
  set(slq "Slq<tenon::CdprTrackingProblem<${cables}> >")
  foreach(function
      "KinoCentroidalModel<${cables}>::Derivative" "KinoCentroidalModel<${cables}>::Step"
      "KinoCentroidalModel<${cables}>::LinearizeSteps" "${slq}::Start" "${slq}::Backward" "${slq}::RollOut")
    if(NOT symbols MATCHES "tenon::${function}\\([^\n]*\\[clone \\.arch_x86_64_v3\\]")
      message(SEND_ERROR "no clone of ${function} in ${LIBRARY}")
    endif()
  endforeach()
endforeach()
foreach(function
    "DualActiveSet::Run<int>" "DualActiveSet::Run<std::integral_constant<int, 12> >" "DualActiveSet::Join<int>"
    "DualActiveSet::AddViolated<int>" "WholeBodyQp::MakeProblem")
  if(NOT symbols MATCHES "tenon::${function}\\([^\n]*\\[clone \\.arch_x86_64_v3\\]")
    message(SEND_ERROR "no clone of ${function} in ${LIBRARY}")
  endif()
endforeach()

# Flattens a SPIR-V module: inlines all functions and replaces variables by values. The passes neither fold
# nor reorder arithmetic. FOLD=ON also folds constants, for shading shaders only: no test compares their
# variants bit for bit, and the driver gets half of the code.
#
#   cmake -DSPIRV_OPT=... -DMODULE=file.spv [-DFOLD=ON] -P flatten.cmake
set(fold "")
if(FOLD)
  set(fold --ccp --simplify-instructions --redundancy-elimination --eliminate-dead-code-aggressive --merge-blocks)
endif()
execute_process(
  COMMAND ${SPIRV_OPT} --target-env=vulkan1.3 --scalar-block-layout --inline-entry-points-exhaustive
          --eliminate-dead-functions --scalar-replacement=0 --ssa-rewrite --eliminate-dead-code-aggressive
          --eliminate-dead-branches --merge-blocks ${fold} ${MODULE} -o ${MODULE}
  RESULT_VARIABLE result
  ERROR_VARIABLE said)  # functions that it left unchanged
if(NOT result EQUAL 0)
  message(FATAL_ERROR "spirv-opt ${MODULE}: ${said}")
endif()

# Puts a shader's functions into one and its variables into values. No arithmetic is changed: none of these passes folds or reorders any.
# With FOLD it may be, where constants meet: for what shades, of which no two variants are compared to the bit, and of which the driver
# then has half as much to read.
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
  ERROR_VARIABLE said)  # which functions it left as they are
if(NOT result EQUAL 0)
  message(FATAL_ERROR "spirv-opt ${MODULE}: ${said}")
endif()

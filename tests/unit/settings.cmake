# Draw settings and their table.
if(TARGET fire3dv_settings)
  fire3dv_test(setting_table_test SOURCES settings/setting_table_test.cpp LINK fire3dv_settings LABELS unit)
endif()

# The live view: its memory, and its page in headless Chromium, an optional package.
find_program(FIRE3DV_CHROMIUM NAMES chromium chromium-browser)
if(TARGET fire3dv AND TARGET bullet_arm AND NOT FIRE3DV_SANITIZE)
  fire3dv_e2e_test(live_memory SCRIPT browser/live_view_test.py PROGRAMS fire3dv bullet_arm e2e_publisher CASES memory)
  set_property(TEST live_memory PROPERTY LABELS long)  # 600 images and 130 viewers
  fire3dv_e2e_test(live_paths SCRIPT browser/live_view_test.py PROGRAMS fire3dv bullet_arm e2e_publisher CASES paths late_shadows)
  fire3dv_e2e_test(live_jupyter SCRIPT browser/live_view_test.py PROGRAMS fire3dv bullet_arm e2e_publisher CASES jupyter)
  if(FIRE3DV_CHROMIUM)
    # The cases of one test share a browser.
    fire3dv_e2e_test(browser_views SCRIPT browser/browser_test.py PROGRAMS fire3dv bullet_arm CASES image cameras touch nodes)
    fire3dv_e2e_test(browser_streams SCRIPT browser/browser_test.py PROGRAMS fire3dv bullet_arm CASES stream video replay)
    fire3dv_e2e_test(browser_access SCRIPT browser/browser_test.py PROGRAMS fire3dv bullet_arm CASES viewers access restart tls)
    fire3dv_e2e_test(browser_proxy SCRIPT browser/browser_test.py PROGRAMS fire3dv bullet_arm CASES proxy)
    if(TARGET fire3dv_client)  # the module of Python publishes
      fire3dv_e2e_test(browser_panels SCRIPT browser/browser_panels_test.py PROGRAMS fire3dv)
      set_property(TEST browser_panels APPEND PROPERTY ENVIRONMENT "PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python"
                   "FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
    endif()
    fire3dv_e2e_test(live_slow SCRIPT browser/live_view_test.py PROGRAMS fire3dv bullet_arm e2e_publisher CASES slow)
    set_tests_properties(live_slow PROPERTIES SKIP_RETURN_CODE 77)
  else()
    message(STATUS "Chromium is not installed: the tests of the live view's page are left out")
  endif()
endif()

# The window: behind a virtual screen with real keys, and drawn into a framebuffer.
add_test(NAME window.real_keys COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/window/real_keys.sh $<TARGET_FILE:halflight>)
set_tests_properties(window.real_keys PROPERTIES SKIP_RETURN_CODE 77 LABELS "window" TIMEOUT 300 RUN_SERIAL TRUE)
halflight_unit_test(app_camera_controls halflight_viewer)
halflight_unit_test(app_render_thread halflight_viewer LABELS threaded)

#include "daemon/app/light_record.hpp"

#include "tests/catch.hpp"

TEST_CASE("The light's record is in the service manager's first folder, else beside the control socket") {
  ::unsetenv("RUNTIME_DIRECTORY");
  CHECK(light_record_path("/tmp/printer/control.sock") == "/tmp/printer/light.json");
  ::setenv("RUNTIME_DIRECTORY", "/run/contourd:/run/other", 1);
  CHECK(light_record_path("/tmp/printer/control.sock") == "/run/contourd/light.json");
  ::setenv("RUNTIME_DIRECTORY", "", 1);
  CHECK(light_record_path("/tmp/printer/control.sock") == "/tmp/printer/light.json");
  ::unsetenv("RUNTIME_DIRECTORY");
}

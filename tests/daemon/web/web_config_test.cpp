#include "daemon/web/web_config.hpp"

#include <fmt/format.h>

#include <fstream>

#include "daemon/json/config_error.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace contourd::testing;
using namespace contourd::web;
using namespace std::chrono_literals;

namespace {

WebConfig config_of(const std::string& text) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "web.json";
  std::ofstream(file) << text;
  return load_web_config(file);
}

}  // namespace

TEST_CASE("the settings of the page have defaults") {
  const WebConfig config = config_of("{}");
  CHECK(config.control_socket == "/run/contourd/control.sock");
  CHECK(config.names.empty());
  CHECK(config.session == 168h);
  CHECK(config.largest_upload_bytes == std::uint64_t{1} << 30U);
  CHECK(config.min_free_disk_bytes == std::uint64_t{256} << 20U);
}

TEST_CASE("the settings of the page arrive with their units") {
  const WebConfig config = config_of(R"({"control_socket": "/tmp/x.sock", "names": ["Printer.Example.org"],
      "session_hours": 2, "largest_upload_mb": 3, "min_free_disk_mb": 0})");
  CHECK(config.control_socket == "/tmp/x.sock");
  CHECK(config.names == std::vector<std::string>{"printer.example.org"});
  CHECK(config.session == 2h);
  CHECK(config.largest_upload_bytes == 3U << 20U);
  CHECK(config.min_free_disk_bytes == 0);
}

TEST_CASE("the ports for clients without a password are off, and have only listed clients") {
  CHECK_FALSE(config_of("{}").nanodlp);
  const WebConfig config = config_of(R"({"nanodlp": {"clients": ["192.168.1.30", "FE80:0:0::1"]}})");
  REQUIRE(config.nanodlp);
  CHECK(config.nanodlp->port == 80);
  CHECK(config.nanodlp->clients == std::vector<std::string>{"192.168.1.30", "fe80::1"});
  // An IPv4 client comes without the IPv6 address in which a socket for both kinds has it.
  CHECK(config_of(R"({"nanodlp": {"clients": ["::FFFF:192.168.1.30", "0:0::1"]}})").nanodlp->clients ==
        std::vector<std::string>{"192.168.1.30", "::1"});
  for (const char* clients :
       {"[]", R"(["printer"])", R"(["192.168.1.0/24"])", R"(["192.168.1.300"])", R"(["::g"])",
        R"(["192.168.1.30:80"])", R"(["192.168.001.030"])", R"(["::ffff:192.168.1"])", R"(["fe80::1%eth0"])",
        R"(["0.0.0.0"])", R"(["::"])", R"(["::ffff:0:0"])", R"(["255.255.255.255"])", R"(["224.0.0.251"])",
        R"(["ff02::1"])", "null"})
    CHECK_THROWS_AS(config_of(fmt::format(R"({{"nanodlp": {{"clients": {}}}}})", clients)), ConfigError);
  CHECK_THROWS_AS(config_of(R"({"nanodlp": {"port": 80}})"), ConfigError);
  CHECK(config_of(R"({"odyssey": {"clients": ["127.0.0.1"]}})").odyssey->port == 12357);
  CHECK(message_of<ConfigError>([] {
          (void)config_of(
              R"({"nanodlp": {"port": 9, "clients": ["::1"]}, "odyssey": {"port": 9, "clients": ["::1"]}})");
        }).find("nanodlp has the port 9, too") != std::string::npos);
  CHECK_THROWS_AS(config_of(R"({"nanodlp": {"port": 0, "clients": ["127.0.0.1"]}})"), ConfigError);
}

TEST_CASE("a wrong setting of the page is refused with its place") {
  for (const char* text : {R"({"session_hours": 0})", R"({"names": ["a:80"]})", R"({"names": "a"})",
                           R"({"nmaes": []})", R"({"largest_upload_mb": 1.5})", "[]", ""})
    CHECK(message_of<ConfigError>([text] { (void)config_of(text); }).find("web.json") != std::string::npos);
  CHECK_THROWS_AS(load_web_config("/nowhere/web.json"), ConfigError);
}

#include "daemon/web/request_checks.hpp"

#include "tests/catch.hpp"

using namespace contourd::web;

TEST_CASE("the host of a request is read without its port, and nonsense is no host") {
  CHECK(host_of("192.168.1.20:8080") == "192.168.1.20");
  CHECK(host_of("Printer.LOCAL") == "printer.local");
  CHECK(host_of("printer.local.:80") == "printer.local");
  CHECK(host_of("[fe80::1]:8080") == "fe80::1");
  CHECK(host_of("[::1]") == "::1");
  for (const char* header : {"", "a b", "a:b", "a:1:2", "[::1", "[::1]x", "a/b", "a:123456", "b\xc3\xbc"})
    CHECK(host_of(header).empty());
  CHECK(host_of(std::string(300, 'a')).empty());
}

TEST_CASE("a host is the own one by its address, by its name, or by a loopback name on a loopback address") {
  const std::vector<std::string> names{"printer"};
  CHECK(is_own_host("192.168.1.20", "192.168.1.20", names));
  CHECK(is_own_host("printer", "192.168.1.20", names));
  CHECK(is_own_host("printer.local", "192.168.1.20", names));
  CHECK(is_own_host("localhost", "127.0.0.1", names));
  CHECK(is_own_host("localhost", "::1", names));
  CHECK_FALSE(is_own_host("localhost", "192.168.1.20", names));
  CHECK_FALSE(is_own_host("192.168.1.21", "192.168.1.20", names));
  CHECK_FALSE(is_own_host("printer.evil", "192.168.1.20", names));
  CHECK_FALSE(is_own_host("printer.local.evil", "192.168.1.20", names));
  CHECK_FALSE(is_own_host("", "", names));
}

TEST_CASE("a request is cross-site if the browser says so, or if its origin is not the host") {
  CHECK_FALSE(is_cross_site({"printer:8080", "", ""}));
  CHECK_FALSE(is_cross_site({"printer:8080", "http://printer:8080", "same-origin"}));
  CHECK_FALSE(is_cross_site({"printer:8080", "http://Printer:8080", ""}));
  CHECK_FALSE(is_cross_site({"printer", "", "none"}));
  CHECK(is_cross_site({"printer:8080", "http://printer", ""}));
  CHECK(is_cross_site({"printer:8080", "http://evil", ""}));
  CHECK(is_cross_site({"printer:8080", "null", ""}));
  CHECK(is_cross_site({"printer:8080", "", "same-site"}));
  CHECK(is_cross_site({"printer:8080", "http://printer:8080", "cross-site"}));
}

TEST_CASE("a cookie is found by its whole name") {
  CHECK(cookie_of("contourd=1", "contourd") == "1");
  CHECK(cookie_of("a=2; contourd=1; b=3", "contourd") == "1");
  CHECK(cookie_of("xcontourd=2; contourdx=3", "contourd").empty());
  CHECK(cookie_of("contourd", "contourd").empty());
  CHECK(cookie_of("", "contourd").empty());
  CHECK(cookie_of(";;=;contourd=", "contourd").empty());
}

TEST_CASE("a model's name stays in its folder and can be shown") {
  CHECK(why_bad_file_name("part.stl").empty());
  CHECK(why_bad_file_name("my part (2).STL").empty());
  CHECK(why_bad_file_name("schön.stl").empty());
  for (const char* name : {"", ".stl", "..", "../a.stl", "/a.stl", "a/b.stl", "a\\b.stl", ".a.stl", "a\n.stl",
                           "a\x1b.stl", "\xff.stl", "part", "part.exe"})
    CHECK_FALSE(why_bad_file_name(name).empty());
  CHECK_FALSE(why_bad_file_name(std::string(201, 'a') + ".stl").empty());
  for (const char* blank : {" .stl", "  .stl.gz", "\u00A0\u3000.stl", "\u2003 .3mf", "\u2800.sl1"})
    CHECK(why_bad_file_name(blank).find("blank") != std::string::npos);
  CHECK(why_bad_file_name(" a.stl").empty());
  CHECK(why_bad_file_name("part.sl1").empty());
  CHECK(why_bad_file_name("part.SL1S").empty());
  CHECK(why_bad_file_name("part.sl1_svg").empty());
}

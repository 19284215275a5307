#include "daemon/web/hosts/host_access.hpp"

#include "tests/catch.hpp"

using namespace contourd::web;

namespace {

const HostAccess kAccess{.clients = {"192.168.1.30", "fe80::1"}, .names = {"printer"}};
const HostCaller kClient{.peer = "192.168.1.30", .local = "192.168.1.20", .host = "192.168.1.20:80"};

HostCaller client_with(std::string HostCaller::*field, const std::string& value) {
  HostCaller caller = kClient;
  caller.*field = value;
  return caller;
}

}  // namespace

TEST_CASE("A listed client that names the printer may use the port of another host's interface") {
  CHECK(why_no_client(kClient, kAccess).empty());
  CHECK(why_no_client(client_with(&HostCaller::peer, "fe80::1"), kAccess).empty());
  CHECK(why_no_client(client_with(&HostCaller::host, "printer.local"), kAccess).empty());
  CHECK(why_no_client(client_with(&HostCaller::user_agent, "Dart/3.5 (dart:io)"), kAccess).empty());
}

TEST_CASE("A client that is not listed, or names another computer, may not use the port") {
  for (const char* peer : {"192.168.1.31", "192.168.1.3", "192.168.1.300", "127.0.0.1", "::1", ""})
    CHECK(why_no_client(client_with(&HostCaller::peer, peer), kAccess).find("may not use this port") !=
          std::string::npos);
  for (const char* host : {"evil.example", "", "192.168.1.21"})
    CHECK(why_no_client(client_with(&HostCaller::host, host), kAccess).find("not a name or an address") !=
          std::string::npos);
}

TEST_CASE("A browser may not use the port, wherever its page is from") {
  for (const HostCaller& caller :
       {client_with(&HostCaller::origin, "http://192.168.1.20"), client_with(&HostCaller::origin, "null"),
        client_with(&HostCaller::sec_fetch_site, "none"),
        client_with(&HostCaller::referer, "http://192.168.1.20:8080/"),
        client_with(&HostCaller::user_agent, "Mozilla/5.0 (iPhone)"),
        client_with(&HostCaller::accept_language, "en")})
    CHECK(why_no_client(caller, kAccess).find("not for a browser") != std::string::npos);
}

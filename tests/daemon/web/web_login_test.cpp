#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "daemon/web/login_guard.hpp"
#include "daemon/web/web_secrets.hpp"
#include "daemon/web/web_sessions.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd::testing;
using namespace contourd::web;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::steady_clock::time_point kStart{1000s};

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
  ::chmod(file.c_str(), 0600);
}

}  // namespace

TEST_CASE("a password fits its own hash only, and each hash has a salt of its own") {
  const std::string hash = hash_of("correct horse");
  CHECK(hash.starts_with("$y$"));
  CHECK(is_password("correct horse", hash));
  CHECK_FALSE(is_password("correct horsf", hash));
  CHECK_FALSE(is_password("", hash));
  CHECK_FALSE(is_password("correct horse", ""));
  CHECK_FALSE(is_password("correct horse", "*"));
  CHECK(hash != hash_of("correct horse"));
}

TEST_CASE("equal texts are equal in constant time, too") {
  CHECK(equal_in_constant_time("", ""));
  CHECK(equal_in_constant_time("abc", "abc"));
  CHECK_FALSE(equal_in_constant_time("abc", "abd"));
  CHECK_FALSE(equal_in_constant_time("abc", "ab"));
  CHECK_FALSE(equal_in_constant_time("abc", "Abc"));
}

TEST_CASE("secrets are read as they were written, and only their owner can read the file") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "web-password";
  const WebSecrets secrets{"$y$j9T$salt$hash", random_hex(16)};
  write_secrets(file, secrets);
  struct stat status {};
  REQUIRE(::stat(file.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777U) == 0600U);
  CHECK(read_secrets(file).password_hash == secrets.password_hash);
  CHECK(read_secrets(file).key == secrets.key);
}

TEST_CASE("the passwords of the roles are kept, and a password gives the highest role that has it") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "web-password";
  WebSecrets secrets{hash_of("printing it"), random_hex(16)};
  secrets.watch_hash = hash_of("watching it");
  write_secrets(file, secrets);
  WebSecrets read = read_secrets(file);
  CHECK(role_with("printing it", read) == Role::Print);
  CHECK(role_with("watching it", read) == Role::Watch);
  CHECK_FALSE(role_with("serving it", read));
  CHECK_FALSE(role_with("", read));
  read.service_hash = read.watch_hash;
  CHECK(role_with("watching it", read) == Role::Service);
  write_file(file, "password $y$x\nkey 00112233445566778899aabbccddeeff\nservice x\n");
  CHECK(message_of<std::runtime_error>([&file] {
          (void)read_secrets(file);
        }).find("contourctl web password") != std::string::npos);
}

TEST_CASE("a role may do what the roles before it may, and has a name") {
  for (const Role role : kRoles)
    CHECK(role_of(name_of(role)) == role);
  CHECK_FALSE(role_of("root"));
  CHECK_FALSE(role_of(""));
  CHECK(Role::Watch < Role::Print);
  CHECK(Role::Print < Role::Service);
}

TEST_CASE("a file without secrets is refused with the command that makes one") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "web-password";
  const auto complaint = [&file] {
    return message_of<std::runtime_error>([&file] { (void)read_secrets(file); });
  };
  CHECK(complaint().find("contourctl web password") != std::string::npos);
  for (const char* text :
       {"", "password x\n", "password $y$x\nkey \n", "password $1$x\nkey 00112233445566778899aabbccddeeff\n",
        "key 00112233445566778899aabbccddeeff\n", "password $y$x\nkey 00112233445566778899AABBCCDDEEFF\n"}) {
    write_file(file, text);
    CHECK(complaint().find("contourctl web password") != std::string::npos);
  }
  write_file(file, "password $y$x\nkey 00112233445566778899aabbccddeeff\n");
  CHECK(read_secrets(file).password_hash == "$y$x");
  ::chmod(file.c_str(), 0604);
  CHECK(complaint().find("other users can read") != std::string::npos);
}

TEST_CASE("after free tries an address waits twice as long for each further one, and no other address does") {
  LoginGuard guard;
  for (int i = 1; i < LoginGuard::kFreeTries; ++i) {
    guard.tried("a", kStart);
    CHECK(guard.wait_of("a", kStart) == 0s);
  }
  auto now = kStart;
  for (const auto wait : {1s, 2s, 4s, 8s, 16s, 32s, 60s, 60s}) {
    guard.tried("a", now);
    CHECK(guard.wait_of("a", now) == wait);
    CHECK(guard.wait_of("a", now + wait - 1ms) == 1s);
    now += wait;
    CHECK(guard.wait_of("a", now) == 0s);
  }
  CHECK(guard.wait_of("b", now) == 0s);
  guard.succeeded("a");
  guard.tried("a", now);
  CHECK(guard.wait_of("a", now) == 0s);
}

TEST_CASE("tries are forgotten after a while, and any number of addresses takes bounded memory") {
  LoginGuard guard;
  for (int i = 0; i < 10; ++i)
    guard.tried("a", kStart);
  const auto later = kStart + LoginGuard::kForgottenAfter + 1s;
  guard.tried("b", later);
  guard.tried("a", later);
  CHECK(guard.wait_of("a", later) == 0s);
  for (std::size_t i = 0; i < 2 * LoginGuard::kMostAddresses; ++i)
    guard.tried(std::to_string(i), later);
  // Addresses beyond the limit share their tries.
  CHECK(guard.wait_of("new", later) > 0s);
}

TEST_CASE("the logins of a role end no session of another role") {
  WebSessions sessions(1h);
  const std::string print = sessions.open(Role::Print, kStart),
                    service = sessions.open(Role::Service, kStart);
  const std::string first = sessions.open(Role::Watch, kStart);
  for (std::size_t i = 0; i < WebSessions::kMostOfRole; ++i)
    (void)sessions.open(Role::Watch, kStart);
  CHECK(sessions.role_of(print, kStart) == Role::Print);
  CHECK(sessions.role_of(service, kStart) == Role::Service);
  CHECK_FALSE(sessions.role_of(first, kStart));
}

TEST_CASE("a session is open until it expires, is closed, or is the oldest of too many") {
  WebSessions sessions(1h);
  const std::string token = sessions.open(Role::Service, kStart);
  CHECK(token.size() == 64);
  CHECK(sessions.role_of(token, kStart) == Role::Service);
  CHECK(sessions.role_of(token, kStart + 1h - 1s));
  CHECK_FALSE(sessions.role_of(token, kStart + 1h));
  CHECK_FALSE(sessions.role_of("", kStart));
  CHECK_FALSE(sessions.role_of(std::string(64, '0'), kStart));
  const std::string second = sessions.open(Role::Service, kStart);
  sessions.close(second);
  CHECK_FALSE(sessions.role_of(second, kStart));
  for (std::size_t i = 0; i < WebSessions::kMostOfRole; ++i)
    (void)sessions.open(Role::Service, kStart);
  CHECK_FALSE(sessions.role_of(token, kStart));
}

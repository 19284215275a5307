#include "hw/drm/card.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

TEST_CASE("The DRM master is found in the kernel's list of a card's clients") {
  CHECK(master_among("             command  tgid dev master a   uid      magic\n"
                     "      systemd-logind   478   0   n    y     0          0\n"
                     "                Xorg   612   0   y    y     0          0\n") == "Xorg (process 612)");
}

TEST_CASE("A master's name may contain blanks, and newer kernels have more columns") {
  CHECK(master_among("             command  tgid dev master a   uid      magic                               "
                     "     name    id\n"
                     "       Web Content 2   713   0   y    y  1000          0                               "
                     " <unset>     5\n") == "Web Content 2 (process 713)");
}

TEST_CASE("A list without a master gives nullopt") {
  CHECK_FALSE(master_among("").has_value());
  CHECK_FALSE(master_among("             command  tgid dev master a   uid      magic\n"
                           "      systemd-logind   478   0   n    y     0          0\n")
                  .has_value());
}

TEST_CASE("If no process is visible the sentence says how to find the master") {
  CHECK(describe_master_holder("/dev/dri/card97") ==
        "another program is its DRM master; run `fuser -v /dev/dri/card97` as root to find it");
}

TEST_CASE("Another process that has the card open is named, unless it is a child of this one") {
  const testing::TemporaryFolder folder;
  const std::string card = folder.write("card0", "");
  const auto words_with_card_open_in = [&card](bool grandchild) {
    int ready[2];
    REQUIRE(::pipe(ready) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
      if (grandchild && ::fork() != 0) ::_exit(0);
      const FileDescriptor open_card(::open(card.c_str(), O_RDONLY | O_CLOEXEC));
      const pid_t self = ::getpid();
      (void)!::write(ready[1], &self, sizeof self);
      ::pause();
    }
    pid_t holder = 0;
    if (grandchild) ::waitpid(child, nullptr, 0);
    REQUIRE(::read(ready[0], &holder, sizeof holder) == sizeof holder);
    const std::string words = describe_master_holder(card);
    ::kill(holder, SIGKILL);
    if (!grandchild) ::waitpid(child, nullptr, 0);
    ::close(ready[0]);
    ::close(ready[1]);
    return words.find("(process " + std::to_string(holder) + ")") != std::string::npos;
  };
  CHECK(words_with_card_open_in(true));
  CHECK_FALSE(words_with_card_open_in(false));
}

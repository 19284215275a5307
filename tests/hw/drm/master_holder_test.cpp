#include "hw/drm/master_holder.hpp"

#include <fcntl.h>

#include <fstream>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

TEST_CASE("The DRM master is found in the kernel's list of a card's clients") {
  CHECK(master_among("             command  tgid dev master a   uid      magic\n"
                     "      systemd-logind   478   0   n    y     0          0\n"
                     "                Xorg   612   0   y    y     0          0\n") == "Xorg (process 612)");
}

TEST_CASE("A master's name may hold blanks, and newer kernels have more columns") {
  CHECK(master_among("             command  tgid dev master a   uid      magic                               "
                     "     name    id\n"
                     "       Web Content 2   713   0   y    y  1000          0                               "
                     " <unset>     5\n") == "Web Content 2 (process 713)");
}

TEST_CASE("A list without a master names none") {
  CHECK_FALSE(master_among("").has_value());
  CHECK_FALSE(master_among("             command  tgid dev master a   uid      magic\n"
                           "      systemd-logind   478   0   n    y     0          0\n")
                  .has_value());
}

TEST_CASE("Where nobody can be seen the sentence says how to find out") {
  CHECK(describe_master_holder("/dev/dri/card97") ==
        "another program is its DRM master; `fuser -v /dev/dri/card97`, run as root, names it");
}

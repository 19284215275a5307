// Catch2 of either major version: Debian 12 has 2, Debian 13 has 3.
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
namespace contourd::testing {
using Catch::Approx;
}
#else
#include <catch2/catch.hpp>
namespace contourd::testing {
using Catch::Detail::Approx;
}
#endif

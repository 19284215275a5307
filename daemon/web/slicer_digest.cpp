#include "daemon/web/slicer_digest.hpp"

#include <microhttpd.h>

#include <memory>

// libmicrohttpd 1.0 marks these functions as outdated; 0.9.75 has no others.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace contourd::web {
namespace {

constexpr const char* kRealm = "contourd";
constexpr unsigned kNonceSeconds = 300;

}  // namespace

DigestCheck check_digest(MHD_Connection* connection, const std::string& key) {
  const int result =
      MHD_digest_auth_check2(connection, kRealm, kSlicerUser, key.c_str(), kNonceSeconds, MHD_DIGEST_ALG_MD5);
  if (result == MHD_YES) return DigestCheck::Good;
  return result == MHD_INVALID_NONCE ? DigestCheck::Stale : DigestCheck::Absent;
}

std::string digest_user(MHD_Connection* connection) {
  const std::unique_ptr<char, decltype(&MHD_free)> user(MHD_digest_auth_get_username(connection), MHD_free);
  return user ? user.get() : "";
}

bool ask_for_digest(MHD_Connection* connection, MHD_Response* response, bool stale) {
  constexpr const char* kOpaque = "contourd";
  return MHD_queue_auth_fail_response2(connection, kRealm, kOpaque, response, stale ? MHD_YES : MHD_NO,
                                       MHD_DIGEST_ALG_MD5) == MHD_YES;
}

}  // namespace contourd::web

#pragma GCC diagnostic pop

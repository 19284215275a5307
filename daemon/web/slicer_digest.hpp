// Digest authentication (RFC 7616) of slicers that know a user and a password: the password is the key. Event
// loop's thread only.
#pragma once

#include <string>

struct MHD_Connection;
struct MHD_Response;

namespace contourd::web {

// The user that slicers name, as on Prusa's printers.
inline constexpr const char* kSlicerUser = "maker";

enum class DigestCheck {
  Absent,  // the request has no digest, or a wrong one
  Stale,   // right, but its nonce is too old
  Good
};
[[nodiscard]] DigestCheck check_digest(MHD_Connection* connection, const std::string& key);

// Returns the user that a digest names, right or wrong; empty without a digest.
[[nodiscard]] std::string digest_user(MHD_Connection* connection);

// Sends the response as a 401 that asks for a digest; `stale` if the last one was only too old. Returns false
// if the connection has to be closed.
[[nodiscard]] bool ask_for_digest(MHD_Connection* connection, MHD_Response* response, bool stale);

}  // namespace contourd::web

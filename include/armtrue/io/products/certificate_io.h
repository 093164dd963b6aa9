#pragma once

#include <optional>
#include <string>

#include "armtrue/certification/certificate.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

struct AboutFile {
  About about;
  std::string name;  ///< of the file, for messages and provenance
  std::string sha256;
};

/// Reads an armtrue-about/1 document. Throws InputError with file, line and key.
AboutFile read_about(const std::string& path);

/// armtrue-certificate/1. `comparison`: with an older certificate, if there is one.
Document write_certificate(const Certificate& certificate,
                           const std::optional<Comparison>& comparison,
                           const Provenance& provenance);

struct CertificateFile {
  CertifiedValues values;
  std::string name;
  std::string sha256;
};

/// Reads what compare() needs from an armtrue-certificate/1 document; ignores its other keys.
/// Throws InputError with file, line and key.
CertificateFile read_certificate(const std::string& path);

}  // namespace armtrue

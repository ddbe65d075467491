// The smallest program that uses an installed moulage.
#include <cstdio>

#include <moulage.hpp>

int main() {
    moulage::check_version();
    std::printf("moulage %s\n", mlg_version_string());
}

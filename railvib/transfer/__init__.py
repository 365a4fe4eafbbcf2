"""Tables of the transfer functions of track and ground over frequency and wavenumber."""

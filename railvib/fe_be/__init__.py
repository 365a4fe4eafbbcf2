"""Track and ground by coupled 2.5D finite and boundary elements: the verification model."""

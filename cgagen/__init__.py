"""cgagen: from an evolved genome to proven firmware for both Stamps of a hexapod."""

__version__ = "0.1.0"
